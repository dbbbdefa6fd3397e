#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace metronome::record {

/// A log file of whole records: what is in it can always be read, whatever went wrong before.
/// Not thread-safe.
class RecordFile {
 public:
  /// @return length of the longest prefix of `content` that is whole records.
  using WholePrefix = std::function<std::size_t(std::string_view content)>;

  /// Opens the file, or makes it, and cuts it back to `keep_bytes`. A file that is shorter, missing
  /// or ends amid a record is said so in a warning and kept as far as it is whole.
  /// @throws std::system_error if the file cannot be opened, read or cut.
  RecordFile(std::string path, std::uint64_t keep_bytes, const WholePrefix& whole_prefix);
  ~RecordFile();
  RecordFile(const RecordFile&) = delete;
  RecordFile& operator=(const RecordFile&) = delete;

  /// Hands a record to the operating system, behind those that could not be written so far. What
  /// fails (disk full, say) is logged once, and kept for the next Append or Flush: a run goes on
  /// without its log. Beyond kMostWaiting bytes records are lost, with an error.
  /// @return whether the record is in the file or waits.
  bool Append(std::string_view record);

  /// Tries to write what waits. @return whether nothing waits any more.
  bool Flush();

  /// Flush, and all of it on disk. @return whether it is; if not, errno says why.
  bool Sync();

  [[nodiscard]] std::uint64_t size() const { return size_; }  // of whole records in the file

  static constexpr std::size_t kMostWaiting = std::size_t{64} << 20;

 private:
  void CutTo(std::uint64_t bytes);

  std::string path_;
  int fd_ = -1;
  std::uint64_t size_ = 0;
  std::string waiting_;
};

}  // namespace metronome::record
