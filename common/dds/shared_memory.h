#pragma once

#include <cstdint>
#include <string>

#include "common/dds/workarounds/locked_file.h"

namespace metronome::dds {

/// Bytes of the memory that a participant writes to, by its role: a history of episodes and then
/// some; observers send next to nothing.
std::uint32_t SegmentBytes(const std::string& role);

/// The shared-memory files of one participant, noted in a file beside them
/// (/dev/shm/metronome-DOMAIN-RUN-PROCESS-N, locked while the process lives), so that what a killed
/// process leaves behind - 16 MB each - can be told from what is in use and from what is not ours.
/// Not thread-safe.
class SharedMemoryNote {
 public:
  /// Removes what dead processes of the run left on this machine, makes the note and sees to it
  /// that there is room: Fast DDS maps its memory without asking, and a process that writes to
  /// memory which is not there dies of SIGBUS. Until Write(), no other process of ours gets past
  /// this, so that two that start at once do not count on the same room.
  /// @param role  of the participant that is to be made.
  /// @param for_an_actor_too  there must also be room for an actor, unless somebody of the run is
  ///        here already: a learner that nobody can join is of no use.
  /// @throws std::invalid_argument that says what is missing and the ways out.
  SharedMemoryNote(const std::string& run_name, std::uint32_t domain, const std::string& role,
                   bool for_an_actor_too = false);
  /// Removes the note.
  ~SharedMemoryNote();
  SharedMemoryNote(const SharedMemoryNote&) = delete;
  SharedMemoryNote& operator=(const SharedMemoryNote&) = delete;

  /// Notes the files of the participant that was just made.
  void Write();

 private:
  bool TryRoom(std::uint32_t bytes);
  bool WaitForRoom(std::uint32_t bytes);
  void Note(const std::string& names);

  workarounds::LockedFile turn_;  // the folder: one process at a time asks for room and takes it
  std::string path_;
  workarounds::LockedFile file_;
};

}  // namespace metronome::dds
