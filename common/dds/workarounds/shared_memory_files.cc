#include "common/dds/workarounds/shared_memory_files.h"

#include <fcntl.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <set>
#include <string_view>
#include <system_error>

#include "common/dds/workarounds/locked_file.h"

namespace metronome::dds::workarounds {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSegment = "fastrtps_";  // Fast DDS 2.9: segments and ports begin so
constexpr std::string_view kLock = "_el";           // ends the name of the lock beside each

/// "123-1": what follows the prefix of the run's own notes alone; names of other runs may begin
/// with this one's.
bool IsProcessAndCount(std::string_view text) {
  const std::size_t dash = text.find('-');
  const auto digits = [](std::string_view part) {
    return !part.empty() &&
           std::all_of(part.begin(), part.end(), [](char c) { return c >= '0' && c <= '9'; });
  };
  return dash != std::string_view::npos && digits(text.substr(0, dash)) &&
         digits(text.substr(dash + 1));
}

/// A note may have been written by anybody: nothing but Fast DDS' files in the folder is removed.
bool IsFileName(const std::string& name) {
  return (name.starts_with(kSegment) || name.starts_with("sem." + std::string(kSegment))) &&
         name.find('/') == std::string::npos;
}

bool IsSegment(const std::string& name) {
  return IsFileName(name) && name.starts_with(kSegment) && name.find("port") == std::string::npos &&
         !name.ends_with(kLock);
}

bool Remove(const std::string& name) {
  std::error_code ignored;  // gone already, or another user's
  return fs::remove(fs::path(kSharedMemoryFolder) / name, ignored);
}

/// Fast DDS' own rule: the process that made a segment holds the lock beside it as long as it
/// lives.
bool IsOfADeadProcess(const std::string& segment) {
  return LockedFile(fs::path(kSharedMemoryFolder) / (segment + std::string(kLock)), O_RDONLY)
      .TryLock();
}

/// The segment of a process that died before it could note it: not older than its note.
std::size_t RemoveUnnoted(const fs::path& note) {
  std::size_t removed = 0;
  std::error_code error;
  const auto noted = fs::last_write_time(note, error);
  if (error) return 0;
  for (fs::directory_iterator entry(kSharedMemoryFolder, error), end; entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename();
    if (!IsSegment(name) || entry->last_write_time(error) < noted || error) continue;
    if (!IsOfADeadProcess(name)) continue;
    removed += static_cast<std::size_t>(Remove(name)) +
               static_cast<std::size_t>(Remove(name + std::string(kLock)));
  }
  return removed;
}

std::size_t RemoveNoted(const fs::path& note) {
  std::size_t removed = 0;
  bool has_segment = false;
  std::ifstream lines(note);
  for (std::string name; std::getline(lines, name);) {
    has_segment = has_segment || IsSegment(name);
    if (IsFileName(name) && Remove(name)) ++removed;
  }
  if (!has_segment) removed += RemoveUnnoted(note);
  std::error_code ignored;
  fs::remove(note, ignored);
  return removed;
}

/// Segments that this process has mapped: right after a participant is made, those of its own.
std::set<std::string> MappedSegments() {
  std::set<std::string> names;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    const std::string name = line.substr(line.rfind('/') + 1);
    if (IsSegment(name)) names.insert(name);
  }
  return names;
}

}  // namespace

std::uint32_t SharedMemoryPort() {
  constexpr std::uint32_t kFirst = 1 << 16;
  constexpr std::uint32_t kLast = std::uint32_t{1} << 31;
  static const std::uint32_t port = [] {
    std::random_device random;
    return std::uniform_int_distribution<std::uint32_t>(kFirst, kLast)(random);
  }();
  return port;
}

Others RemoveLeftovers(const std::string& prefix) {
  std::size_t files = 0;
  Others others;
  std::error_code unreadable;
  for (const auto& entry : fs::directory_iterator(kSharedMemoryFolder, unreadable)) {
    const std::string name = entry.path().filename();
    if (!name.starts_with(prefix) || !IsProcessAndCount(name.substr(prefix.size()))) continue;
    const LockedFile note(entry.path(), O_RDONLY);
    if (!note.TryLock()) {
      ++others.alive;
      continue;
    }
    files += RemoveNoted(entry.path());
    ++others.dead;
  }
  if (files > 0) {
    spdlog::info("removed {} shared-memory files that {} killed process{} of this run left", files,
                 others.dead, others.dead == 1 ? "" : "es");
  }
  return others;
}

std::string PortFiles() {
  const std::string port = std::string(kSegment) + "port" + std::to_string(SharedMemoryPort());
  return port + "\n" + port + std::string(kLock) + "\nsem." + port + "_mutex\n";
}

std::string SegmentFiles() {
  std::string names;
  for (const std::string& segment : MappedSegments()) {
    names.append(segment).append("\n").append(segment).append(kLock).append("\n");
  }
  return names;
}

}  // namespace metronome::dds::workarounds
