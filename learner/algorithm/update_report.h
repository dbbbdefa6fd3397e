#pragma once

#include <string>
#include <vector>

#include "common/checkpoint/train_state.h"
#include "common/messages/episode.h"
#include "common/schema/config.pb.h"
#include "learner/algorithm/metric.h"

namespace metronome::algorithm {

/// Figures of episodes, means over them.
struct EpisodeFigures {
  double mean_return = 0;  // undiscounted episode return
  double success = 0;      // share of episodes with success at any step
  double success_end = 0;  // share with success at the last step
};

/// One task's episodes in a batch.
struct TaskReport : EpisodeFigures {
  std::string name;
};

/// The figures of one update: a pure function of state and batch. The counters are those after
/// the update.
struct UpdateReport : checkpoint::RunCounters, EpisodeFigures {  // the latter of the whole batch
  std::vector<TaskReport> tasks;  // of each of several tasks, in their order; empty: one task
  std::vector<Metric> metrics;    // the algorithm's own
};

/// Each of several tasks of a run, without figures; empty: it has one.
std::vector<TaskReport> TasksOf(const RunConfig& config);

/// The counters after one more update, from `batch`.
checkpoint::RunCounters CountersAfter(const checkpoint::RunCounters& before,
                                      const std::vector<Episode>& batch);

/// All of a report but the algorithm's own metrics.
/// @param batch  not empty; of several tasks, with equally many episodes of each.
UpdateReport ReportOf(const RunConfig& config, const checkpoint::RunCounters& after,
                      const std::vector<Episode>& batch);

}  // namespace metronome::algorithm
