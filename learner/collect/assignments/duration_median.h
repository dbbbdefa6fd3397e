#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <optional>
#include <vector>

namespace metronome::collect::assignments {

/// Median of the last kWindow durations. Not thread-safe.
class DurationMedian {
 public:
  static constexpr std::size_t kWindow = 101;

  void Add(std::chrono::nanoseconds duration) {
    if (window_.size() < kWindow) {
      window_.push_back(duration);
    } else {
      window_[next_] = duration;
    }
    next_ = (next_ + 1) % kWindow;
    std::vector<std::chrono::nanoseconds> sorted = window_;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    median_ = *middle;
  }

  /// std::nullopt before the first Add. The upper one of two middles.
  [[nodiscard]] std::optional<std::chrono::nanoseconds> median() const { return median_; }

 private:
  std::vector<std::chrono::nanoseconds> window_;
  std::size_t next_ = 0;
  std::optional<std::chrono::nanoseconds> median_;
};

}  // namespace metronome::collect::assignments
