#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/checkpoint/checkpoint.h"
#include "common/messages/episode.h"
#include "learner/record/record_file.h"

namespace metronome::record {

/// A run's replay cannot be gone on with; what() names the file and says why.
class ReplayDamaged : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The episodes that an algorithm with a replay keeps (sac.replay_steps), in RUN_FOLDER/replay/:
/// one record each, in number order, in segments FIRST_NUMBER.episodes that are only ever appended
/// to. A checkpoint says which episodes its replay has and their digest, so resuming finds the same
/// ones or none. A segment that neither today's replay nor the newest checkpoints need is removed.
///
/// Record, little-endian: uint32 bytes of the payload | uint32 CRC-32C of it | payload: uint64
/// number, uint64 weights version, uint32 T, O, A, then the arrays of Episode in their order.
///
/// Not thread-safe.
class EpisodeLog {
 public:
  /// The episodes of a checkpoint's replay. Changes nothing.
  /// @throws ReplayDamaged where one is missing, torn, changed or of another run.
  static std::vector<Episode> Read(const std::string& run_folder,
                                   const checkpoint::ReplayPosition& position);

  /// Goes on behind `position`: what was written after it is cut off.
  /// @param most_steps  of the environment, that the replay holds. @param checkpoints  how many of
  ///                    the newest must find their replay.
  /// @throws std::system_error, see RecordFile.
  EpisodeLog(const std::string& run_folder, const checkpoint::ReplayPosition& position,
             std::uint64_t most_steps, std::uint64_t checkpoints);
  ~EpisodeLog();

  /// Writes a batch; it is in the file when this returns, or waits for room (see RecordFile).
  void Append(const std::vector<Episode>& batch);

  /// Makes sure that all of it is on disk. @return whether it is; if not, errno says why. Once an
  /// episode was lost it never is again: a checkpoint would not find its replay.
  bool Sync();
  /// What a checkpoint of now must find.
  [[nodiscard]] checkpoint::ReplayPosition position() const;
  /// A checkpoint with position() is on disk: removes segments that nobody needs any more.
  void Saved();

 private:
  struct Entry {  // an episode of the replay
    std::uint64_t number = 0;
    std::uint32_t checksum = 0;
    std::uint32_t steps = 0;
  };

  void OpenSegment(std::uint64_t first, std::uint64_t keep_bytes);
  void Forget();

  std::string folder_;
  std::uint64_t most_steps_;
  std::uint64_t checkpoints_;
  std::deque<Entry> entries_;
  std::uint64_t steps_ = 0;             // of entries_
  std::uint64_t next_ = 0;              // number of the next episode
  std::deque<std::uint64_t> segments_;  // their first numbers
  std::deque<std::uint64_t> needed_;    // first numbers of the newest checkpoints' replays
  std::unique_ptr<RecordFile> file_;    // of the last segment
  bool lost_ = false;                   // an episode found no room even to wait
};

}  // namespace metronome::record
