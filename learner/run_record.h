#pragma once

#include <cstdint>
#include <string>

#include "common/train_state.h"
#include "learner/batch_store.h"
#include "learner/ledger_counts.h"
#include "learner/update_report.h"

namespace metronome {

/// Wall-clock facts of an update and of the actors: shown and logged, never used. Two equal runs
/// may differ in these alone.
struct WallClock {
  double seconds = 0;         // since this process began to serve the run
  double fps = 0;             // environment steps a second since then
  double eta_seconds = 0;     // at that rate
  double update_seconds = 0;  // of this update's own computation
  double idle_share = 0;      // of the slots' time since the last update
  std::uint64_t actors = 0;
  std::uint64_t slots = 0;
  std::uint64_t bytes_sent = 0;  // payload since the start of this process
  std::uint64_t bytes_received = 0;
};

/// Where a run's results go: checkpoints, logs, the terminal. Not thread-safe. Any of these may
/// throw (the disk is full, say); the coordinator says so loudly and goes on.
class RunRecord {
 public:
  virtual ~RunRecord() = default;
  /// Writes a checkpoint; the one before stays until it is safely there. @return its path.
  virtual std::string Save(const TrainState& state) = 0;
  /// Path of the newest checkpoint that was written.
  [[nodiscard]] virtual std::string LatestCheckpoint() const = 0;
  /// The run is accepted: actors may come.
  virtual void Started(const TrainState& state) = 0;
  virtual void Updated(const UpdateReport& report, const WallClock& wall) = 0;
  virtual void Finished(const TrainState& state, const std::string& accounting) = 0;
  /// Stopped before its end by a signal.
  virtual void Interrupted(const TrainState& state) = 0;
};

}  // namespace metronome
