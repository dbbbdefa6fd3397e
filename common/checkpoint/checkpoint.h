#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "common/checkpoint/train_state.h"
#include "common/config/environment_spec.h"
#include "common/schema/config.pb.h"

/// Checkpoints: everything that a run needs to go on, in one file.
///
/// Frame, little-endian: "METRCKPT" | uint32 format version | uint64 payload bytes | SHA-256 of
/// the 20 bytes before it and of the payload | payload (common/schema/checkpoint.proto).
namespace metronome::checkpoint {

/// Format written. Grows whenever an older build would misread the payload; it refuses a newer
/// format by name. The frame stays.
/// 2: the configuration names the heads' schedule and the critic's heads (1: blocks, separate).
/// 3: and the correlation of exploration noise (before: 0).
/// 4: and what success adds to the reward (before: 0).
/// 5: and what is added to the variance of observations (before: 1e-8).
/// 6: and describes the environment (before: a Meta-World task, described by who knows its name);
///    the policy by itself, and the algorithm's state as bytes of a format of its own (before:
///    PPO's state alone, in the open).
/// 7: and is of a build whose numbers are those of common/kernels/ and common/numbers/elementary.h
///    (before: Eigen's and the C library's; the canonical digest of such a run is not read).
/// 8: and may be without settings that have the defaults of today's runs (before: those of
///    old_config.h).
inline constexpr std::uint32_t kCheckpointFormat = 8;
/// The oldest format that is read; the newest is kCheckpointFormat.
inline constexpr std::uint32_t kOldestCheckpointFormat = 1;

/// How far the run's logs had come (learner/record/progress_log.h): resuming cuts them back to
/// this.
struct LogOffsets {
  std::uint64_t progress_bytes = 0;  // of progress.csv
  std::uint64_t events_bytes = 0;    // of the TensorBoard event file
  double wall_seconds = 0;           // wall-clock: time the run has taken, all starts together
  bool operator==(const LogOffsets&) const = default;
};

/// The episodes of the replay, of an algorithm that has one (learner/record/episode_log.h): numbers
/// first .. next - 1.
struct ReplayPosition {
  std::uint64_t first = 0;
  std::uint64_t next = 0;
  std::string sha256;  // of numbers and checksums of their records
  bool operator==(const ReplayPosition&) const = default;
};

struct Checkpoint {
  RunConfig config;  // resolved
  TrainState state;
  std::string engine;             // EngineName() of the learner that wrote it
  std::string build;              // its BuildIdentity()
  std::string isa;                // its instruction set, see common/kernels/; empty: not noted
  std::uint64_t incarnation = 0;  // its incarnation
  LogOffsets logs;
  ReplayPosition replay;
  std::string initial_weights_sha256;  // of what policy.initial_weights named; empty: of nothing
};

/// The policy of a checkpoint by itself: what it takes to play, and to say which run it is of
/// (configuration, counters, digest of all weights). The algorithm's state, without which no run
/// goes on, and the logs are left out; AlgorithmState::format is then kPolicyAlone.
Checkpoint PolicyAlone(Checkpoint checkpoint);

/// The file cannot be used; what() names it and says why.
class CheckpointError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Its bytes are not those that were written: empty, torn, changed. It never can be used again.
class CheckpointDamaged : public CheckpointError {
 public:
  using CheckpointError::CheckpointError;
};

/// It cannot be read now (permissions, a disk that fails, no such file). It may be whole.
class CheckpointUnreadable : public CheckpointError {
 public:
  using CheckpointError::CheckpointError;
};

/// The whole file as bytes, and back. The same checkpoint gives the same bytes.
/// @param name    of the file, for messages.
/// @param source  asked what the environment is like if the checkpoint does not say: below
///                format 6.
/// The algorithm's state is not looked into.
/// @throws CheckpointDamaged, and CheckpointError for anything else but a checkpoint of a known
///         format whose policy fits its configuration.
std::string EncodeCheckpoint(const Checkpoint& checkpoint);
Checkpoint DecodeCheckpoint(std::string_view bytes, const std::string& name,
                            const config::SpecSource& source);

/// @throws CheckpointError, see DecodeCheckpoint, and CheckpointUnreadable; where the file is
///         damaged or cannot be read, what() names the checkpoints that lie beside it.
Checkpoint LoadCheckpoint(const std::string& path, const config::SpecSource& source);

/// @throws CheckpointError naming both shapes if the checkpoint's network does not have the shape
///         that `config` (resolved) asks for.
void RequireShape(const Checkpoint& checkpoint, const RunConfig& config, const std::string& name);

/// @throws CheckpointError if it is a policy by itself.
void RequireState(const Checkpoint& checkpoint, const std::string& name);

/// A checkpoint to go on from.
struct FoundCheckpoint {
  struct PassedOver {
    std::string path;
    std::string why;  // names the path
  };
  std::string path;
  Checkpoint checkpoint;
  std::vector<PassedOver> passed_over;  // damaged or missing, and would have been taken first
};

/// The newest checkpoint of a run's folder of checkpoints that is whole. What `latest` names comes
/// first, then older ones, then (nothing else is left) newer ones; without a word of `latest`, the
/// newest. Changes nothing.
/// @return std::nullopt if the folder holds no trace of a checkpoint.
/// @throws CheckpointDamaged naming each file if none is whole; CheckpointError, with the command
///         that goes back to another one, if the one to take is whole and cannot be used, or cannot
///         be read.
std::optional<FoundCheckpoint> FindNewestCheckpoint(const std::string& folder,
                                                    const config::SpecSource& source);

/// The checkpoints of one run: FOLDER/000123.ckpt for version 123, FOLDER/latest a link to the
/// newest. One writer per folder (the run's lock); not thread-safe.
class CheckpointStore {
 public:
  /// Makes the folder if needed and removes what a killed writer left half-written.
  /// @param keep             newest files that pruning leaves, at least 1; those of versions above
  ///                         the one just written (the run was set back) are left too.
  /// @param milestone_every  versions that are multiples of it are never pruned, nor counted among
  ///                         the newest; 0: none.
  /// @throws std::system_error if the folder cannot be made.
  CheckpointStore(std::string folder, int keep, int milestone_every = 0);

  /// Writes the file, points `latest` at it and prunes. The old checkpoint stays until the new
  /// one is safely on disk. @return the path.
  /// @throws std::system_error (disk full, say): `latest` and what it names are as they were.
  std::string Save(const Checkpoint& checkpoint);

  /// Makes `found` what `latest` names, and renames what was passed over to NAME.damaged: no later
  /// start takes it for good, and pruning counts good ones alone.
  /// @throws std::system_error naming the path.
  void GoOnFrom(const FoundCheckpoint& found);

  /// Path of the newest checkpoint: what `latest` names, else (the link is missing) the file of the
  /// highest version; std::nullopt if there is none.
  [[nodiscard]] std::optional<std::string> Latest() const;

 private:
  void PutAside(const std::string& path) const;
  void Prune(std::uint64_t newest) const;

  std::string folder_;
  int keep_;
  std::uint64_t milestone_every_;
};

}  // namespace metronome::checkpoint
