#pragma once

#include <condition_variable>
#include <cstdint>

#include "common/messages/bus.h"
#include "common/process/mutex.h"

namespace metronome::dds {

/// Where middleware threads say "something changed" and the consumer waits for it. The samples
/// themselves stay in the readers' bounded histories until they are asked for, so that a slow
/// consumer pushes back on the writers. Thread-safe.
class Inbox {
 public:
  void Notify() {
    {
      const process::MutexLock lock(mutex_);
      ++changes_;
    }
    changed_.notify_all();
  }

  void Wake() {
    {
      const process::MutexLock lock(mutex_);
      woken_ = true;
      ++changes_;
    }
    changed_.notify_all();
  }

  /// Whether Wake was called since the last time this returned true.
  bool TakeWoken() {
    const process::MutexLock lock(mutex_);
    const bool woken = woken_;
    woken_ = false;
    return woken;
  }

  [[nodiscard]] std::uint64_t changes() const {
    const process::MutexLock lock(mutex_);
    return changes_;
  }

  /// Blocks until changes() differs from `seen`. @return false at the deadline.
  bool WaitForChange(std::uint64_t seen, Clock::time_point deadline) {
    process::MutexLock lock(mutex_);
    return changed_.wait_until(lock, deadline,
                               [&]() METRONOME_REQUIRES(mutex_) { return changes_ != seen; });
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
  mutable process::Mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t changes_ METRONOME_GUARDED_BY(mutex_) = 0;
  bool woken_ METRONOME_GUARDED_BY(mutex_) = false;
};

}  // namespace metronome::dds
