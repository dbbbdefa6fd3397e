#pragma once

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <utility>

namespace metronome::dds::workarounds {

/// An open file or folder and its lock (flock), which ends with it. errno says what went wrong.
class LockedFile {
 public:
  LockedFile() = default;
  /// @param flags  of open(2).
  LockedFile(const std::string& path, int flags)
      : descriptor_(open(path.c_str(), flags | O_CLOEXEC, 0600)) {}
  ~LockedFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  LockedFile(LockedFile&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  LockedFile& operator=(LockedFile&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }

  [[nodiscard]] int get() const { return descriptor_; }
  /// Waits for whoever has the lock. @return false if the file is not open, or cannot be locked.
  [[nodiscard]] bool Lock() const {
    while (descriptor_ >= 0) {
      if (flock(descriptor_, LOCK_EX) == 0) return true;
      if (errno != EINTR) break;
    }
    return false;
  }
  /// @return false also if somebody else has the lock.
  [[nodiscard]] bool TryLock() const {
    return descriptor_ >= 0 && flock(descriptor_, LOCK_EX | LOCK_NB) == 0;
  }

 private:
  int descriptor_ = -1;
};

}  // namespace metronome::dds::workarounds
