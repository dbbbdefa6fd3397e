#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "learner/record/metrics.h"
#include "learner/record/record_file.h"

namespace metronome::record {

/// progress.csv: a header, then one row an update, each number in the shortest form that reads back
/// as the same bits. Two runs of equal configuration have equal columns but for the wall-clock
/// ones. Columns: learner/README.md. Not thread-safe.
class ProgressLog {
 public:
  /// Of a file that is to be gone on with: rows of this build under another header would be taken
  /// for other columns. @throws std::invalid_argument with the remedy.
  /// @param blank  a report of the run, whatever its values: its tasks and its algorithm's metrics.
  static void RequireHeader(const std::string& path, const algorithm::UpdateReport& blank);

  /// @param blank       as above.
  /// @param keep_bytes  LogOffsets::progress_bytes of the checkpoint gone on from; 0: a new file.
  /// @throws std::system_error, see RecordFile.
  ProgressLog(const std::string& path, const algorithm::UpdateReport& blank,
              std::uint64_t keep_bytes);

  /// Writes a row; it is in the file when this returns, or waits for room (see RecordFile).
  void Append(const std::vector<algorithm::Metric>& metrics);

  /// For LogOffsets::progress_bytes.
  [[nodiscard]] std::uint64_t bytes() const { return file_.size(); }

  /// See RecordFile.
  bool Flush() { return file_.Flush(); }

 private:
  RecordFile file_;
};

}  // namespace metronome::record
