#include "learner/record/run_folder.h"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <exception>
#include <filesystem>
#include <limits>
#include <system_error>
#include <utility>

#include "common/process/files.h"
#include "common/process/process_identity.h"

namespace metronome::record {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void Fail(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

// The holder of the lock, for the message alone: the lock itself never depends on it.
std::string HolderText() {
  return "process " + std::to_string(getpid()) + " on " + process::HostName();
}

/// Whether making the folder failed because another process made or removed it meanwhile.
bool IsRace(const std::error_code& error, const std::string& path) {
  if (error != std::errc::file_exists) return false;
  std::error_code unknown;
  const fs::file_type there = fs::symlink_status(path, unknown).type();
  return there == fs::file_type::not_found || there == fs::file_type::directory;
}

/// Whether `path` names the open file.
bool IsAt(int descriptor, const std::string& path) {
  struct stat opened {};
  struct stat named {};
  return fstat(descriptor, &opened) == 0 && stat(path.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

}  // namespace

RunFolder::RunFolder(std::string path) : path_(std::move(path)) { Lock(); }

RunFolder::~RunFolder() {
  RemoveIfUnused();
  close(lock_);
}

// Whoever had the folder before may remove it, and the lock's file, between any two steps here.
void RunFolder::Lock() {
  do {
    std::error_code error;
    fs::create_directories(path_, error);
    if (error && !IsRace(error, path_)) {
      throw std::system_error(error,
                              "cannot make " + path_ + " (--runs DIR: another folder of runs)");
    }
  } while (!TryLock());
  const std::string text = HolderText() + "\n";
  if (ftruncate(lock_, 0) != 0 || pwrite(lock_, text.data(), text.size(), 0) < 0) {
    spdlog::warn("{} does not say who holds the run: {}", File("lock"),
                 std::generic_category().message(errno));
  }
}

bool RunFolder::TryLock() {
  const std::string file = File("lock");
  lock_ = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (lock_ < 0 && errno == ENOENT && !fs::is_symlink(file)) return false;
  if (lock_ < 0) Fail("cannot lock " + file);
  if (flock(lock_, LOCK_EX | LOCK_NB) == 0) {
    if (IsAt(lock_, file)) return true;
    close(lock_);
    return false;
  }
  const int error = errno;
  std::array<char, 256> holder{};
  const bool known = pread(lock_, holder.data(), holder.size() - 1, 0) > 0;
  close(lock_);
  errno = error;
  if (error != EWOULDBLOCK) Fail("cannot lock " + file);
  std::string who = known ? holder.data() : "a process that did not say who it is";
  while (who.ends_with('\n')) who.pop_back();
  throw RunFolderBusy("a learner of this run is alive: " + who + " holds " + file +
                      "; stop it first, or give this run another --run NAME");
}

std::uint64_t RunFolder::NextIncarnation(std::uint64_t seen) {
  const std::string file = File("incarnation");
  std::uint64_t last = 0;
  if (fs::is_directory(file)) {
    fs::rename(file, file + ".damaged");
    spdlog::warn("{} is a folder, now {}.damaged; going on from the checkpoint's {}", file, file,
                 seen);
  }
  if (fs::exists(file)) {
    const std::string text = process::ReadFile(file);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), last);
    if (error != std::errc() || last == std::numeric_limits<std::uint64_t>::max()) {
      spdlog::warn("{} holds no number that can grow; going on from the checkpoint's {}", file,
                   seen);
      last = 0;
    }
  }
  const std::uint64_t next = std::max(last, seen) + 1;
  process::WriteFileAtomically(file, std::to_string(next) + "\n");
  return next;
}

// A folder that cannot be read stays.
void RunFolder::RemoveIfUnused() const noexcept try {
  std::error_code error;
  for (fs::directory_iterator entry(path_, error), end; entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename();
    if (name != "lock" && name != "incarnation") return;
  }
  if (error) return;
  fs::remove(File("incarnation"), error);
  fs::remove(File("lock"), error);
  fs::remove(path_, error);
} catch (const std::exception& error) {
  spdlog::warn("{} stays: {}", path_, error.what());
}

std::string ConfigPathOf(const std::string& run_folder) {
  return (fs::path(run_folder) / "config.textproto").string();
}

}  // namespace metronome::record
