#pragma once

#include <cstdint>
#include <string>

namespace metronome::dds {

/// Shared-memory ports are numbered by process, beyond any UDP port: a killed process leaves its
/// port behind locked, and one that takes its place must not run into it.
std::uint32_t SharedMemoryPort();

/// The shared-memory files of one participant, noted in a file beside them
/// (/dev/shm/metronome-DOMAIN-RUN-PROCESS-N, locked while the process lives), so that what a killed
/// process leaves behind - 16 MB each - can be told from what is in use and from what is not ours.
/// Not thread-safe.
class SharedMemoryNote {
 public:
  /// Removes what dead processes of the run left on this machine, then makes the note.
  /// @throws std::system_error if it cannot be made.
  SharedMemoryNote(const std::string& run_name, std::uint32_t domain);
  /// Removes the note.
  ~SharedMemoryNote();
  SharedMemoryNote(const SharedMemoryNote&) = delete;
  SharedMemoryNote& operator=(const SharedMemoryNote&) = delete;

  /// Notes the files of the participant that was just made.
  void Write();

 private:
  bool Lock();

  std::string path_;
  int file_ = -1;
};

}  // namespace metronome::dds
