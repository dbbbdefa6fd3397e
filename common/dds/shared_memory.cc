#include "common/dds/shared_memory.h"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>

namespace metronome::dds {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFolder = "/dev/shm";
constexpr std::string_view kSegment = "fastrtps_";  // Fast DDS 2.9: segments and ports begin so

std::string PrefixOf(const std::string& run_name, std::uint32_t domain) {
  return "metronome-" + std::to_string(domain) + "-" + run_name + "-";
}

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

std::size_t RemoveNoted(const fs::path& note) {
  std::size_t removed = 0;
  std::ifstream lines(note);
  for (std::string name; std::getline(lines, name);) {
    std::error_code ignored;  // gone already, or another user's
    if (IsFileName(name) && fs::remove(fs::path(kFolder) / name, ignored)) ++removed;
  }
  std::error_code ignored;
  fs::remove(note, ignored);
  return removed;
}

void RemoveLeftovers(const std::string& prefix) {
  std::size_t dead = 0, files = 0;
  std::error_code unreadable;
  for (const auto& entry : fs::directory_iterator(kFolder, unreadable)) {
    const std::string name = entry.path().filename();
    if (!name.starts_with(prefix) || !IsProcessAndCount(name.substr(prefix.size()))) continue;
    const int file = open(entry.path().c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) continue;
    if (flock(file, LOCK_EX | LOCK_NB) == 0) {  // its process is dead
      files += RemoveNoted(entry.path());
      ++dead;
    }
    close(file);
  }
  if (dead > 0) {
    spdlog::info("removed {} shared-memory files that {} killed process{} of this run left", files,
                 dead, dead == 1 ? "" : "es");
  }
}

/// Segments that this process has mapped: right after a participant is made, those of its own.
std::set<std::string> MappedSegments() {
  std::set<std::string> names;
  std::ifstream maps("/proc/self/maps");
  const std::string folder = std::string(kFolder) + "/";
  for (std::string line; std::getline(maps, line);) {
    const std::size_t at = line.find(folder);
    if (at == std::string::npos) continue;
    const std::string name = line.substr(at + folder.size());
    if (IsFileName(name) && name.find("port") == std::string::npos) names.insert(name);
  }
  return names;
}

}  // namespace

std::uint32_t SharedMemoryPort() {
  constexpr std::uint32_t kFirst = 1 << 16;
  return kFirst + static_cast<std::uint32_t>(getpid());
}

SharedMemoryNote::SharedMemoryNote(const std::string& run_name, std::uint32_t domain) {
  static std::atomic<int> count{0};
  const std::string prefix = PrefixOf(run_name, domain);
  RemoveLeftovers(prefix);
  path_ = std::string(kFolder) + "/" + prefix + std::to_string(getpid()) + "-" +
          std::to_string(++count);
  while (!Lock()) {
  }
}

// @return false if another process took the note, not yet locked, for a dead one's and removed it.
bool SharedMemoryNote::Lock() {
  file_ = open(path_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  struct stat state {};
  if (file_ < 0 || flock(file_, LOCK_EX) != 0 || fstat(file_, &state) != 0) {
    throw std::system_error(errno, std::generic_category(), path_);
  }
  if (state.st_nlink > 0) return true;
  close(file_);
  return false;
}

SharedMemoryNote::~SharedMemoryNote() {
  unlink(path_.c_str());
  close(file_);
}

void SharedMemoryNote::Write() {
  std::ostringstream names;
  const std::string port_name = "fastrtps_port" + std::to_string(SharedMemoryPort());
  for (const std::string& segment : MappedSegments()) {
    names << segment << "\n" << segment << "_el\n";
  }
  names << port_name << "\n"
        << port_name << "_el\n"
        << "sem." << port_name << "_mutex\n";
  const std::string text = names.str();
  if (pwrite(file_, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size())) {
    spdlog::warn("{} does not say what this process would leave behind if it were killed: {}",
                 path_, std::generic_category().message(errno));
  }
}

}  // namespace metronome::dds
