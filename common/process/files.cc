#include "common/process/files.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <system_error>

namespace metronome::process {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void Fail(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

/// An open file descriptor; closes at the end of its scope.
class Descriptor {
 public:
  /// Owns `fd`. @param path  for messages.
  Descriptor(int fd, std::string path) : path_(std::move(path)), fd_(fd) {}
  Descriptor(const std::string& path, int flags) : path_(path) {
    fd_ = open(path.c_str(), flags | O_CLOEXEC, 0644);
    if (fd_ < 0) Fail("cannot open " + path);
  }
  ~Descriptor() { close(fd_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  void Write(std::string_view content) {
    while (!content.empty()) {
      const ssize_t written = write(fd_, content.data(), content.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) Fail("cannot write " + path_);
      content.remove_prefix(static_cast<std::size_t>(written));
    }
  }

  std::string ReadAll() {
    std::string content;
    std::array<char, 65536> block{};
    for (;;) {
      const ssize_t got = read(fd_, block.data(), block.size());
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) Fail("cannot read " + path_);
      if (got == 0) return content;
      content.append(block.data(), static_cast<std::size_t>(got));
    }
  }

  void Sync() {
    if (fsync(fd_) != 0) Fail("cannot sync " + path_);
  }

 private:
  std::string path_;
  int fd_ = -1;
};

std::string FolderOf(const std::string& path) {
  const std::string folder = fs::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

void SyncFolderOf(const std::string& path) {
  Descriptor(FolderOf(path), O_RDONLY | O_DIRECTORY).Sync();
}

/// A path beside `path` that is removed again unless Commit ran.
class Temporary {
 public:
  explicit Temporary(std::string path)
      : path_(std::move(path)), name_(path_ + ".tmp." + std::to_string(getpid())) {
    unlink(name_.c_str());  // left by a killed process of the same id
  }
  ~Temporary() {
    if (!committed_) unlink(name_.c_str());
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }

  void Commit() {
    if (rename(name_.c_str(), path_.c_str()) != 0) Fail("cannot replace " + path_);
    committed_ = true;
    SyncFolderOf(path_);
  }

 private:
  std::string path_, name_;
  bool committed_ = false;
};

void WriteAndSync(Descriptor& file, std::string_view content) {
  file.Write(content);
  file.Sync();
}

/// Writes a file that has no name before it is whole, so that nothing is left of it whatever ends
/// the process. @return false if this cannot be done here (no such files on NFS, no /proc).
bool WriteNameless(const std::string& path, std::string_view content) {
  const int fd = open(FolderOf(path).c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0644);
  if (fd < 0) return false;
  Descriptor file(fd, path);
  WriteAndSync(file, content);
  const auto name_it = [source = "/proc/self/fd/" + std::to_string(fd)](const std::string& name) {
    return linkat(AT_FDCWD, source.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0;
  };
  if (name_it(path)) {
    SyncFolderOf(path);
    return true;
  }
  if (errno != EEXIST) return false;
  Temporary temporary(path);  // a link cannot replace a file, renaming can
  if (!name_it(temporary.name())) return false;
  temporary.Commit();
  return true;
}

void WriteNamed(const std::string& path, std::string_view content) {
  Temporary temporary(path);
  {
    Descriptor file(temporary.name(), O_WRONLY | O_CREAT | O_EXCL);
    WriteAndSync(file, content);
  }
  temporary.Commit();
}

}  // namespace

std::string ReadFile(const std::string& path) { return Descriptor(path, O_RDONLY).ReadAll(); }

std::string FileToReplace(const std::string& path) {
  std::error_code error;
  const fs::file_status there = fs::status(path, error);  // what links lead to
  if (!fs::exists(there)) return path;
  if (!fs::is_regular_file(there)) {
    errno = fs::is_directory(there) ? EISDIR : EPERM;
    Fail("cannot write " + path + ": it is no regular file; choose another name");
  }
  if (!fs::is_symlink(fs::symlink_status(path))) return path;
  const fs::path file = fs::canonical(path, error);
  if (error) throw std::system_error(error, "cannot find the file that " + path + " leads to");
  return file.string();
}

void WriteFileAtomically(const std::string& path, std::string_view content) {
  const std::string file = FileToReplace(path);
  if (!WriteNameless(file, content)) WriteNamed(file, content);
}

void ReplaceSymlink(const std::string& link, const std::string& target) {
  Temporary temporary(link);
  if (symlink(target.c_str(), temporary.name().c_str()) != 0) Fail("cannot link " + link);
  temporary.Commit();
}

}  // namespace metronome::process
