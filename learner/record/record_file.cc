#include "learner/record/record_file.h"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "common/process/files.h"

namespace metronome::record {
namespace {

bool WriteAll(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

RecordFile::RecordFile(std::string path, std::uint64_t keep_bytes, const WholePrefix& whole_prefix)
    : path_(std::move(path)) {
  // O_APPEND: after a cut, writing goes on at the new end.
  fd_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (fd_ < 0) throw std::system_error(errno, std::generic_category(), "cannot open " + path_);
  try {
    const std::string content = process::ReadFile(path_);
    const auto kept = std::min<std::size_t>(content.size(), keep_bytes);
    CutTo(whole_prefix(std::string_view(content).substr(0, kept)));
  } catch (...) {
    close(fd_);
    throw;
  }
  if (size_ < keep_bytes) {
    spdlog::warn("{} holds {} bytes of whole records, {} at the checkpoint: some rows are missing",
                 path_, size_, keep_bytes);
  }
}

RecordFile::~RecordFile() { close(fd_); }

bool RecordFile::Append(std::string_view record) {
  if (waiting_.size() + record.size() > kMostWaiting) {
    spdlog::error("a record of {} is lost: {} bytes wait for room already", path_, waiting_.size());
    return false;
  }
  const bool first = waiting_.empty();
  waiting_ += record;
  if (Flush() || !first) return true;
  spdlog::error("cannot write {}: {}; its records wait until there is room, training goes on",
                path_, std::strerror(errno));
  return true;
}

bool RecordFile::Sync() { return Flush() && fdatasync(fd_) == 0; }

bool RecordFile::Flush() {
  if (WriteAll(fd_, waiting_)) {
    size_ += waiting_.size();
    waiting_.clear();
    return true;
  }
  const int error = errno;
  if (ftruncate(fd_, static_cast<off_t>(size_)) != 0) {
    spdlog::error("cannot cut {} back: {}", path_, std::strerror(errno));
  }
  errno = error;
  return false;
}

void RecordFile::CutTo(std::uint64_t bytes) {
  if (ftruncate(fd_, static_cast<off_t>(bytes)) != 0) {
    throw std::system_error(errno, std::generic_category(), "cannot cut " + path_);
  }
  size_ = bytes;
}

}  // namespace metronome::record
