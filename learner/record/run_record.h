#pragma once

#include <string>
#include <vector>

#include "common/checkpoint/train_state.h"
#include "common/messages/episode.h"
#include "learner/algorithm/update_report.h"
#include "learner/collect/trust/excluded_hosts.h"
#include "learner/record/metrics.h"

namespace metronome::record {

/// Where a run's results go: checkpoints, logs, the terminal. Not thread-safe. Any of these may
/// throw (the disk is full, say); the coordinator says so loudly and goes on.
class RunRecord {
 public:
  virtual ~RunRecord() = default;
  /// This learner has the run: folders and files are made, logs cut back to the state it begins
  /// with.
  virtual void Begin() = 0;
  /// Writes a checkpoint; the one before stays until it is safely there. @return its path.
  virtual std::string Save(const checkpoint::TrainState& state) = 0;
  /// Path of the newest checkpoint that was written.
  [[nodiscard]] virtual std::string LatestCheckpoint() const = 0;
  /// The run is accepted: actors may come.
  virtual void Started(const checkpoint::TrainState& state) = 0;
  /// An audit excluded a host: all that are excluded from here on.
  virtual void Excluded(const collect::trust::ExcludedHosts& hosts) = 0;
  /// A batch was learnt from: a replay is kept on disk.
  virtual void Learnt(const std::vector<Episode>& batch) = 0;
  virtual void Updated(const algorithm::UpdateReport& report, const WallReport& wall) = 0;
  virtual void Finished(const checkpoint::TrainState& state, const std::string& accounting) = 0;
  /// Stopped before its end by a signal.
  virtual void Interrupted(const checkpoint::TrainState& state) = 0;
};

}  // namespace metronome::record
