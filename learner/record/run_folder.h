#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

namespace metronome::record {

/// Another learner on this machine (or on this shared disk) has the run's folder.
class RunFolderBusy : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// runs/NAME, held by one learner at a time: an flock on FOLDER/lock that dies with the process,
/// and FOLDER/incarnation, which grows by one at each start. Not thread-safe.
class RunFolder {
 public:
  /// Makes the folder if needed and locks it; does not block.
  /// @throws RunFolderBusy naming who holds it, std::system_error naming the path.
  explicit RunFolder(std::string path);
  /// Lets go; takes back what was made here if nothing else lies in the folder (a start was
  /// refused).
  ~RunFolder();
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;

  /// One more than any incarnation before; on disk when this returns.
  /// @param seen  the highest known from elsewhere (a checkpoint), in case the counter was lost.
  /// @throws std::system_error if it cannot be written.
  std::uint64_t NextIncarnation(std::uint64_t seen);

  [[nodiscard]] const std::string& path() const { return path_; }
  /// Path of a file of the folder.
  [[nodiscard]] std::string File(const std::string& name) const { return path_ + "/" + name; }

 private:
  void Lock();
  /// @return whether the file that is locked is still the one of that name.
  bool TryLock();
  void RemoveIfUnused() const noexcept;

  std::string path_;
  int lock_ = -1;
};

/// RUN_FOLDER/config.textproto, the resolved configuration of a run.
std::string ConfigPathOf(const std::string& run_folder);

}  // namespace metronome::record
