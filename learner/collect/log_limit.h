#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace metronome::collect {

/// Keeps a flood of like complaints out of the log: lets `burst` of them pass per `period`.
/// Pure logic on given time points; not thread-safe.
class LogLimit {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  explicit LogLimit(std::uint32_t burst = 10,
                    std::chrono::milliseconds period = std::chrono::seconds(10))
      : burst_(burst), period_(period) {}

  /// @return whether to log this one.
  bool Pass(TimePoint now) {
    if (!begin_ || now >= *begin_ + period_) {
      begin_ = now;
      passed_ = 0;
    }
    if (passed_ < burst_) {
      ++passed_;
      return true;
    }
    ++withheld_;
    return false;
  }

  /// How many were withheld since the last call.
  std::uint64_t TakeWithheld() {
    const std::uint64_t withheld = withheld_;
    withheld_ = 0;
    return withheld;
  }

 private:
  std::uint32_t burst_;
  std::chrono::milliseconds period_;
  std::optional<TimePoint> begin_;
  std::uint32_t passed_ = 0;
  std::uint64_t withheld_ = 0;
};

}  // namespace metronome::collect
