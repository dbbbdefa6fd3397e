#include "common/dds/shared_memory.h"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <thread>

#include "common/dds/participant_qos.h"

namespace metronome::dds {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFolder = "/dev/shm";         // what the C library's shm_open takes
constexpr std::string_view kSegment = "fastrtps_";  // Fast DDS 2.9: segments and ports begin so
constexpr std::string_view kLock = "_el";           // ends the name of the lock beside each
constexpr std::uint32_t kSegmentBytes = 16 << 20;
constexpr std::uint32_t kObserverSegmentBytes = 1 << 20;
// Beside the segment: its tables, our port, and those that writers make again for peers that died.
constexpr std::uint32_t kPortBytes = 1 << 20;
constexpr std::chrono::seconds kPeersLetGo{5};  // Fast DDS looks once a second
constexpr std::chrono::milliseconds kPoll{50};

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

bool IsSegment(const std::string& name) {
  return IsFileName(name) && name.starts_with(kSegment) && name.find("port") == std::string::npos &&
         !name.ends_with(kLock);
}

bool Remove(const std::string& name) {
  std::error_code ignored;  // gone already, or another user's
  return fs::remove(fs::path(kFolder) / name, ignored);
}

/// Fast DDS' own rule: the process that made a segment holds the lock beside it as long as it
/// lives.
bool IsOfADeadProcess(const std::string& segment) {
  return LockedFile(fs::path(kFolder) / (segment + std::string(kLock)), O_RDONLY).TryLock();
}

/// The segment of a process that died before it could note it: not older than its note.
std::size_t RemoveUnnoted(const fs::path& note) {
  std::size_t removed = 0;
  std::error_code error;
  const auto noted = fs::last_write_time(note, error);
  if (error) return 0;
  for (fs::directory_iterator entry(kFolder, error), end; entry != end; entry.increment(error)) {
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

/// Processes of a run that had notes.
struct Others {
  std::size_t alive = 0;
  std::size_t dead = 0;  // their files are removed
};

Others RemoveLeftovers(const std::string& prefix) {
  std::size_t files = 0;
  Others others;
  std::error_code unreadable;
  for (const auto& entry : fs::directory_iterator(kFolder, unreadable)) {
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
  if (others.dead > 0) {
    spdlog::info("removed {} shared-memory files that {} killed process{} of this run left", files,
                 others.dead, others.dead == 1 ? "" : "es");
  }
  return others;
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

/// Names of the port's files, a line each.
std::string PortFiles() {
  const std::string port = std::string(kSegment) + "port" + std::to_string(SharedMemoryPort());
  return port + "\n" + port + std::string(kLock) + "\nsem." + port + "_mutex\n";
}

std::uint64_t FreeBytes() {
  struct statvfs state {};
  return statvfs(kFolder, &state) == 0 ? std::uint64_t{state.f_bavail} * state.f_frsize : 0;
}

std::string Megabytes(std::uint64_t bytes) { return std::to_string(bytes >> 20) + " MB"; }

/// What errno says of `path`.
std::string ErrorOf(const std::string& path) {
  return path + ": " + std::generic_category().message(errno);
}

[[noreturn]] void Refuse(const std::string& why) {
  throw std::invalid_argument("no shared memory: " + why + ". --transport udp needs none");
}

/// @param who  with its verb.
[[noreturn]] void RefuseWithoutRoom(const std::string& who, std::uint32_t bytes) {
  Refuse(std::string(kFolder) + " has room for " + Megabytes(FreeBytes()) + ", " + who + " " +
         Megabytes(bytes) +
         ". Make it larger (of a container: --shm-size=1g), start fewer processes, or remove what "
         "killed programs left there: fastdds shm clean (of Debian's fastdds-tools)");
}

// What follows is the signal's usual end.
void SayWhatItMeans(int /*signal*/) {
  constexpr std::string_view kText =
      "SIGBUS: memory that is mapped from a file is not there: /dev/shm was filled or emptied "
      "while this process used it (--transport udp does not), or a file of the program changed\n";
  [[maybe_unused]] const auto written = write(STDERR_FILENO, kText.data(), kText.size());
}

/// Others may still take the room that was asked for.
void NameTheCauseOfSigbus() {
  struct sigaction now {};
  if (sigaction(SIGBUS, nullptr, &now) != 0 || now.sa_handler != SIG_DFL) return;
  now.sa_handler = SayWhatItMeans;
  now.sa_flags = SA_RESETHAND;  // the access that failed is made again, and ends the process
  sigaction(SIGBUS, &now, nullptr);
}

}  // namespace

std::uint32_t SegmentBytes(const std::string& role) {
  return role == kObserverRole ? kObserverSegmentBytes : kSegmentBytes;
}

std::uint32_t SharedMemoryPort() {
  constexpr std::uint32_t kFirst = 1 << 16;
  return kFirst + static_cast<std::uint32_t>(getpid());
}

SharedMemoryNote::SharedMemoryNote(const std::string& run_name, std::uint32_t domain,
                                   const std::string& role, bool for_an_actor_too)
    : turn_(kFolder, O_RDONLY | O_DIRECTORY) {
  static std::atomic<int> count{0};
  NameTheCauseOfSigbus();
  if (!turn_.Lock()) Refuse(ErrorOf(kFolder));
  const std::string prefix = PrefixOf(run_name, domain);
  const Others others = RemoveLeftovers(prefix);
  path_ = std::string(kFolder) + "/" + prefix + std::to_string(getpid()) + "-" +
          std::to_string(++count);
  file_ = LockedFile(path_, O_RDWR | O_CREAT | O_TRUNC | O_NOFOLLOW);
  if (!file_.Lock()) Refuse(ErrorOf(path_));
  const bool with_an_actor = for_an_actor_too && others.alive == 0;
  std::uint32_t bytes = SegmentBytes(role) + kPortBytes;
  if (with_an_actor) bytes += SegmentBytes(kActorRole) + kPortBytes;
  if (!TryRoom(bytes) && (others.dead == 0 || !WaitForRoom(bytes))) {
    unlink(path_.c_str());
    RefuseWithoutRoom(with_an_actor ? "this process and an actor need" : "this process needs",
                      bytes);
  }
  Note(PortFiles());
}

// The note itself takes the room for a moment: what the system says of free room does not count
// quotas and limits.
bool SharedMemoryNote::TryRoom(std::uint32_t bytes) {
  const int error = posix_fallocate(file_.get(), 0, bytes);
  if (error == 0 && ftruncate(file_.get(), 0) == 0) return true;
  if (error == ENOSPC) return false;
  unlink(path_.c_str());
  Refuse(path_ + ": " + std::generic_category().message(error));
}

/// For what is removed of a dead process: it is free once its peers do not map it any more.
bool SharedMemoryNote::WaitForRoom(std::uint32_t bytes) {
  spdlog::info("waiting for the peers of the killed to let go of {}", kFolder);
  const auto deadline = std::chrono::steady_clock::now() + kPeersLetGo;
  while (std::chrono::steady_clock::now() < deadline) {
    if (TryRoom(bytes)) return true;
    std::this_thread::sleep_for(kPoll);
  }
  return false;
}

SharedMemoryNote::~SharedMemoryNote() { unlink(path_.c_str()); }

void SharedMemoryNote::Write() {
  std::string names = PortFiles();
  for (const std::string& segment : MappedSegments()) {
    names.append(segment).append("\n").append(segment).append(kLock).append("\n");
  }
  Note(names);
  turn_ = LockedFile();
}

void SharedMemoryNote::Note(const std::string& names) {
  if (pwrite(file_.get(), names.data(), names.size(), 0) == static_cast<ssize_t>(names.size())) {
    return;
  }
  spdlog::warn("{} does not say what this process would leave behind if it were killed: {}", path_,
               std::generic_category().message(errno));
}

}  // namespace metronome::dds
