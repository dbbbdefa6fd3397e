#include "common/dds/shared_memory.h"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <thread>

#include "common/dds/participant_qos.h"
#include "common/dds/workarounds/shared_memory_files.h"

namespace metronome::dds {
namespace {

constexpr std::uint32_t kSegmentBytes = 16 << 20;
constexpr std::uint32_t kObserverSegmentBytes = 1 << 20;
// Beside the segment: its tables, our port, and those that writers make again for peers that died.
constexpr std::uint32_t kPortBytes = 1 << 20;
constexpr std::chrono::seconds kPeersLetGo{5};  // Fast DDS looks once a second
constexpr std::chrono::milliseconds kPoll{50};

std::string PrefixOf(const std::string& run_name, std::uint32_t domain) {
  return "metronome-" + std::to_string(domain) + "-" + run_name + "-";
}

std::uint64_t FreeBytes() {
  struct statvfs state {};
  return statvfs(workarounds::kSharedMemoryFolder, &state) == 0
             ? std::uint64_t{state.f_bavail} * state.f_frsize
             : 0;
}

std::string Megabytes(std::uint64_t bytes) { return std::to_string(bytes >> 20) + " MB"; }

/// "PATH: " and errno's message.
std::string ErrorOf(const std::string& path) {
  return path + ": " + std::generic_category().message(errno);
}

[[noreturn]] void Refuse(const std::string& why) {
  throw std::invalid_argument("no shared memory: " + why + ". --transport udp needs none");
}

/// @param who  with its verb.
[[noreturn]] void RefuseWithoutRoom(const std::string& who, std::uint32_t bytes) {
  Refuse(std::string(workarounds::kSharedMemoryFolder) + " has room for " + Megabytes(FreeBytes()) +
         ", " + who + " " + Megabytes(bytes) +
         ". Make it larger (of a container: --shm-size=1g), start fewer processes, or remove what "
         "killed programs left there: fastdds shm clean (of Debian's fastdds-tools)");
}

// After it the signal takes its usual end.
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

SharedMemoryNote::SharedMemoryNote(const std::string& run_name, std::uint32_t domain,
                                   const std::string& role, bool for_an_actor_too)
    : turn_(workarounds::kSharedMemoryFolder, O_RDONLY | O_DIRECTORY) {
  static std::atomic<int> count{0};
  NameTheCauseOfSigbus();
  if (!turn_.Lock()) Refuse(ErrorOf(workarounds::kSharedMemoryFolder));
  const std::string prefix = PrefixOf(run_name, domain);
  const workarounds::Others others = workarounds::RemoveLeftovers(prefix);
  do {
    path_ = std::string(workarounds::kSharedMemoryFolder) + "/" + prefix +
            std::to_string(getpid()) + "-" + std::to_string(++count);
    file_ = workarounds::LockedFile(path_, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW);
    // A process of the same id in another container has that one.
  } while (file_.get() < 0 && errno == EEXIST);
  if (!file_.Lock()) Refuse(ErrorOf(path_));
  const bool with_an_actor = for_an_actor_too && others.alive == 0;
  std::uint32_t bytes = SegmentBytes(role) + kPortBytes;
  if (with_an_actor) bytes += SegmentBytes(kActorRole) + kPortBytes;
  if (!TryRoom(bytes) && (others.dead == 0 || !WaitForRoom(bytes))) {
    unlink(path_.c_str());
    RefuseWithoutRoom(with_an_actor ? "this process and an actor need" : "this process needs",
                      bytes);
  }
  Note(workarounds::PortFiles());
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
  spdlog::info("waiting for the peers of the killed to let go of {}",
               workarounds::kSharedMemoryFolder);
  const auto deadline = std::chrono::steady_clock::now() + kPeersLetGo;
  while (std::chrono::steady_clock::now() < deadline) {
    if (TryRoom(bytes)) return true;
    std::this_thread::sleep_for(kPoll);
  }
  return false;
}

SharedMemoryNote::~SharedMemoryNote() { unlink(path_.c_str()); }

void SharedMemoryNote::Write() {
  Note(workarounds::PortFiles() + workarounds::SegmentFiles());
  turn_ = workarounds::LockedFile();
}

void SharedMemoryNote::Note(const std::string& names) {
  if (pwrite(file_.get(), names.data(), names.size(), 0) == static_cast<ssize_t>(names.size())) {
    return;
  }
  spdlog::warn("{} does not say what this process would leave behind if it were killed: {}", path_,
               std::generic_category().message(errno));
}

}  // namespace metronome::dds
