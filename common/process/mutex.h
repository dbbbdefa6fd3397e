#pragma once

#include <mutex>

// Clang's builds check at compile time that what a mutex guards is touched under it alone; for
// other compilers these words say nothing. https://clang.llvm.org/docs/ThreadSafetyAnalysis.html
#if defined(__clang__)
#define METRONOME_THREAD_ATTRIBUTE(x) __attribute__((x))
#else
#define METRONOME_THREAD_ATTRIBUTE(x)
#endif
/// Of a variable: it is read and written under that mutex alone.
#define METRONOME_GUARDED_BY(mutex) METRONOME_THREAD_ATTRIBUTE(guarded_by(mutex))
/// Of a function or lambda: its caller holds that mutex.
#define METRONOME_REQUIRES(mutex) METRONOME_THREAD_ATTRIBUTE(requires_capability(mutex))

namespace metronome::process {

/// A std::mutex that Clang knows; std::lock_guard would hide its locking.
class METRONOME_THREAD_ATTRIBUTE(capability("mutex")) Mutex : private std::mutex {
  friend class MutexLock;
};

/// Holds a mutex to the end of its scope. A std::condition_variable takes it; the lambda that it
/// then waits for is a function of its own: METRONOME_REQUIRES.
class METRONOME_THREAD_ATTRIBUTE(scoped_lockable) MutexLock : public std::unique_lock<std::mutex> {
 public:
  explicit MutexLock(Mutex& mutex) METRONOME_THREAD_ATTRIBUTE(acquire_capability(mutex))
      : std::unique_lock<std::mutex>(mutex) {}
  ~MutexLock() METRONOME_THREAD_ATTRIBUTE(release_capability()) = default;
  MutexLock(const MutexLock&) = delete;
  MutexLock& operator=(const MutexLock&) = delete;

  void lock() METRONOME_THREAD_ATTRIBUTE(acquire_capability()) { unique_lock::lock(); }
  void unlock() METRONOME_THREAD_ATTRIBUTE(release_capability()) { unique_lock::unlock(); }
};

}  // namespace metronome::process
