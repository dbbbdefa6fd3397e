#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace metronome::collect::assignments {

/// How much of the actors' time was without an assignment. Not thread-safe.
class IdleTime {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// From the last call until now there were so many envs, and so many of them had no assignment:
  /// to be told before either changes.
  void Count(std::uint64_t envs, std::uint64_t idle, TimePoint now) {
    if (counted_until_) {
      const double seconds = std::chrono::duration<double>(now - *counted_until_).count();
      env_seconds_ += seconds * double(envs);
      idle_seconds_ += seconds * double(idle);
    }
    counted_until_ = now;
  }

  /// Share of env time without an assignment since the last call, in [0, 1]; 0 without envs.
  double TakeShare() {
    const double share = env_seconds_ > 0 ? idle_seconds_ / env_seconds_ : 0;
    env_seconds_ = 0;
    idle_seconds_ = 0;
    return share;
  }

 private:
  std::optional<TimePoint> counted_until_;
  double env_seconds_ = 0;
  double idle_seconds_ = 0;
};

}  // namespace metronome::collect::assignments
