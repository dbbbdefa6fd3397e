#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

/// Files that Fast DDS 2.9 and the notes of common/dds/shared_memory.h leave in the folder of
/// shared memory.
namespace metronome::dds::workarounds {

inline constexpr const char* kSharedMemoryFolder = "/dev/shm";  // what shm_open(3) takes

/// A random number for each process, beyond any UDP port: a killed process leaves its port behind
/// locked, and one that takes its place must not run into it; process ids would be the same in
/// containers that share the folder.
std::uint32_t SharedMemoryPort();

/// Processes of a run that had notes.
struct Others {
  std::size_t alive = 0;
  std::size_t dead = 0;  // their files are removed
};

/// Removes, and logs, what dead processes left: the files that they noted; of one that died before
/// it could note its segment, those of dead processes that are not older than its note.
/// @param prefix  of the run's notes, followed by "PROCESS-COUNT".
Others RemoveLeftovers(const std::string& prefix);

/// Names of the files of this process's port, and of the segments that it has mapped (right after a
/// participant is made, those of its own): a line each.
std::string PortFiles();
std::string SegmentFiles();

}  // namespace metronome::dds::workarounds
