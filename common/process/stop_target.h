#pragma once

#include <functional>
#include <utility>

#include "common/process/mutex.h"

namespace metronome::process {

/// Passes a signal on to what it stops, while there is something. A signal that comes before stops
/// it as soon as it is there. Thread-safe; not for signal handlers.
class StopTarget {
 public:
  /// @param stop  takes the signal's number, and is called under a lock; nullptr: there is nothing
  ///              to stop any more.
  void Set(std::function<void(int signal)> stop) {
    const MutexLock lock(mutex_);
    stop_ = std::move(stop);
    if (stop_ && signal_ != 0) stop_(signal_);
  }
  void Signal(int signal) {
    const MutexLock lock(mutex_);
    signal_ = signal;
    if (stop_) stop_(signal);
  }
  /// The last one; 0: none came.
  [[nodiscard]] int signal() const {
    const MutexLock lock(mutex_);
    return signal_;
  }

 private:
  mutable Mutex mutex_;
  std::function<void(int signal)> stop_ METRONOME_GUARDED_BY(mutex_);
  int signal_ METRONOME_GUARDED_BY(mutex_) = 0;
};

}  // namespace metronome::process
