#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace metronome::collect::orders {

/// How much of the actors' time was without an order. Not thread-safe.
class IdleTime {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// From the last call until now there were so many slots, and so many of them had no order: to be
  /// told before either changes.
  void Count(std::uint64_t slots, std::uint64_t idle, TimePoint now) {
    if (counted_until_) {
      const double seconds = std::chrono::duration<double>(now - *counted_until_).count();
      slot_seconds_ += seconds * double(slots);
      idle_seconds_ += seconds * double(idle);
    }
    counted_until_ = now;
  }

  /// Share of slot time without an order since the last call, in [0, 1]; 0 without slots.
  double TakeShare() {
    const double share = slot_seconds_ > 0 ? idle_seconds_ / slot_seconds_ : 0;
    slot_seconds_ = 0;
    idle_seconds_ = 0;
    return share;
  }

 private:
  std::optional<TimePoint> counted_until_;
  double slot_seconds_ = 0;
  double idle_seconds_ = 0;
};

}  // namespace metronome::collect::orders
