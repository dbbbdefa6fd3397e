#pragma once

#include <cstdint>
#include <vector>

#include "learner/algorithm/metric.h"
#include "learner/algorithm/update_report.h"

/// The metrics that are logged after an update: one list for progress.csv and TensorBoard.
namespace metronome::record {

/// Wall-clock side of an update: the only numbers allowed to differ between two equal runs.
struct WallReport {
  double seconds = 0;  // that the run has taken, all starts together
  // Of this update's batch: from when its assignments could go out to the start of the update. With
  // overlap that includes waiting for the update before.
  double collect_seconds = 0;
  double update_seconds = 0;         // this update: learning alone
  double idle_share = 0;             // of the actors' envs, 0..1, meanwhile; with overlap: since
                                     // the update before began
  std::uint64_t bytes_sent = 0;      // payload, in this incarnation
  std::uint64_t bytes_received = 0;  // payload, in this incarnation
  std::uint64_t actors = 0;          // connected
  std::uint64_t envs = 0;            // episodes that they play at once
  std::uint64_t episodes_reassigned = 0;  // assigned again, in this incarnation
};

/// All metrics in column order: the run's own, the algorithm's, the wall-clock ones.
std::vector<algorithm::Metric> MetricsOf(const algorithm::UpdateReport& report,
                                         const WallReport& wall);

}  // namespace metronome::record
