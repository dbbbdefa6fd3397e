#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>

#include "common/messages/bus.h"

namespace metronome::dds {

/// Where middleware threads say "something changed" and the consumer waits for it. The samples
/// themselves stay in the readers' bounded histories until they are asked for, so that a slow
/// consumer pushes back on the writers. Thread-safe.
class Inbox {
 public:
  void Notify() {
    {
      const std::lock_guard lock(mutex_);
      ++changes_;
    }
    changed_.notify_all();
  }

  void Wake() {
    {
      const std::lock_guard lock(mutex_);
      woken_ = true;
      ++changes_;
    }
    changed_.notify_all();
  }

  /// Whether Wake was called since the last time this returned true.
  bool TakeWoken() {
    const std::lock_guard lock(mutex_);
    const bool woken = woken_;
    woken_ = false;
    return woken;
  }

  [[nodiscard]] std::uint64_t changes() const {
    const std::lock_guard lock(mutex_);
    return changes_;
  }

  /// Blocks until changes() differs from `seen`. @return false at the deadline.
  bool WaitForChange(std::uint64_t seen, Clock::time_point deadline) {
    std::unique_lock lock(mutex_);
    return changed_.wait_until(lock, deadline, [&] { return changes_ != seen; });
  }

  /// Calls `next` (which returns an optional event) until it has one or the deadline passed.
  template <class Next>
  auto Wait(Clock::time_point deadline, Next next) -> decltype(next()) {
    while (true) {
      const std::uint64_t seen = changes();
      if (auto event = next()) return event;
      if (!WaitForChange(seen, deadline)) return std::nullopt;
    }
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t changes_ = 0;
  bool woken_ = false;
};

}  // namespace metronome::dds
