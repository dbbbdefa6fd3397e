#pragma once

#include <condition_variable>
#include <functional>
#include <string>
#include <thread>

#include "common/process/mutex.h"

namespace metronome::run {

/// Runs one piece of work at a time beside the caller.
class Background {
 public:
  virtual ~Background() = default;
  /// Begins `work`, which must not throw. @throws std::logic_error while other work runs.
  virtual void Start(std::function<void()> work) = 0;
  /// Blocks until no work runs.
  virtual void Wait() = 0;
};

/// One named thread. Thread-safe; the destructor waits for the work.
class BackgroundThread final : public Background {
 public:
  /// @param name  of the thread, as debuggers show it; at most 15 characters.
  explicit BackgroundThread(const std::string& name);
  ~BackgroundThread() override;
  void Start(std::function<void()> work) override;
  void Wait() override;

 private:
  void Loop();

  process::Mutex mutex_;
  std::condition_variable changed_;
  std::function<void()> work_ METRONOME_GUARDED_BY(mutex_);  // that is due
  bool runs_ METRONOME_GUARDED_BY(mutex_) = false;
  bool closing_ METRONOME_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace metronome::run
