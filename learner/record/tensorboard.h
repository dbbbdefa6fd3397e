#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "learner/record/metrics.h"
#include "learner/record/record_file.h"

namespace metronome::record {

/// A TensorBoard event file of scalars over environment steps. Tags are Metric::tag; those under
/// wall/ are wall-clock time. Not thread-safe.
/// Format: TFRecord framing (length, masked CRC-32C of the length, data, masked CRC-32C of the
/// data; all little-endian) around Event messages, as TensorFlow's record_writer does.
class TensorBoardLog {
 public:
  /// TensorBoard finds event files by "tfevents" in their name.
  static constexpr char kFileName[] = "events.out.tfevents.metronome";

  /// @param keep_bytes  LogOffsets::events_bytes of the checkpoint gone on from; 0: a new file.
  /// @throws std::system_error, see RecordFile.
  TensorBoardLog(const std::string& path, std::uint64_t keep_bytes);

  /// Writes one event with all metrics at `steps`. A failure is logged, not thrown.
  void Append(std::uint64_t steps, const std::vector<algorithm::Metric>& metrics);

  /// For LogOffsets::events_bytes.
  [[nodiscard]] std::uint64_t bytes() const { return file_.size(); }

  /// See RecordFile.
  bool Flush() { return file_.Flush(); }

 private:
  RecordFile file_;
};

/// CRC-32C (Castagnoli, RFC 3720 appendix B.4).
std::uint32_t Crc32c(std::string_view bytes);

}  // namespace metronome::record
