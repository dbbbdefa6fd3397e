#pragma once

#include <vector>

#include "common/checkpoint/train_state.h"
#include "common/messages/episode.h"
#include "learner/algorithm/metric.h"

namespace metronome::algorithm {

/// The figures of one update: a pure function of state and batch. The counters are those after
/// the update.
struct UpdateReport : checkpoint::RunCounters {
  double mean_return = 0;       // undiscounted episode return, mean over the batch
  double success = 0;           // share of episodes with success at any step
  double success_end = 0;       // share with success at the last step
  std::vector<Metric> metrics;  // the algorithm's own
};

/// The counters after one more update, from `batch`.
checkpoint::RunCounters CountersAfter(const checkpoint::RunCounters& before,
                                      const std::vector<Episode>& batch);

/// All of a report but the algorithm's own metrics. @param batch  not empty.
UpdateReport ReportOf(const checkpoint::RunCounters& after, const std::vector<Episode>& batch);

}  // namespace metronome::algorithm
