#include "learner/record/metrics.h"

#include "learner/record/rates.h"

namespace metronome::record {
namespace {

std::vector<algorithm::Metric> RunMetrics(const algorithm::UpdateReport& report) {
  std::vector<algorithm::Metric> metrics = {
      {"steps", "train/steps", report.steps,
       "environment steps so far; the step of every TensorBoard point"},
      {"update", "train/update", report.version,
       "updates made: the version of the weights after it"},
      {"episodes", "train/episodes", report.episodes_used, "episodes learnt from so far"},
      {"return", "train/return", report.mean_return,
       "mean episode return of the batch: official reward, undiscounted, unscaled"},
      {"success", "train/success", report.success, "share of episodes with success at any step"},
      {"success_end", "train/success_end", report.success_end,
       "share of episodes with success at the last step"}};
  for (const algorithm::TaskReport& task : report.tasks) {
    metrics.push_back({"return_" + task.name, "return/" + task.name, task.mean_return,
                       "of several tasks: `return` of each task's episodes"});
    metrics.push_back({"success_" + task.name, "success/" + task.name, task.success,
                       "of several tasks: `success` of each task's episodes"});
  }
  return metrics;
}

std::vector<algorithm::Metric> WallMetrics(const algorithm::UpdateReport& report,
                                           const WallReport& wall) {
  return {{"fps", "wall/fps", StepsPerSecond(report.steps, wall.seconds),
           "wall-clock: environment steps a second since the start, stops left out"},
          {"wall_seconds", "wall/seconds", wall.seconds,
           "wall-clock: time the run has taken, all starts together"},
          {"wall_collect_seconds", "wall/collect_seconds", wall.collect_seconds,
           "wall-clock: of this batch, from when its assignments could go out to the start of its "
           "update; with `overlap: 1` that includes waiting for the update before"},
          {"wall_update_seconds", "wall/update_seconds", wall.update_seconds,
           "wall-clock: of learning alone"},
          {"wall_idle_share", "wall/idle_share", wall.idle_share,
           "wall-clock: share of the actors' envs without an assignment while collecting; with "
           "`overlap: 1` since the start of the update before, waiting for its end included"},
          {"wall_bytes_sent", "wall/bytes_sent", wall.bytes_sent,
           "wall-clock: payload in this incarnation"},
          {"wall_bytes_received", "wall/bytes_received", wall.bytes_received,
           "wall-clock: payload in this incarnation"},
          {"wall_actors", "wall/actors", wall.actors, "wall-clock: connected actors"},
          {"wall_envs", "wall/envs", wall.envs,
           "wall-clock: the episodes that connected actors play at once"},
          {"wall_episodes_reassigned", "wall/episodes_reassigned", wall.episodes_reassigned,
           "wall-clock: episodes assigned again in this incarnation (lost, late, doubtful)"}};
}

}  // namespace

std::vector<algorithm::Metric> MetricsOf(const algorithm::UpdateReport& report,
                                         const WallReport& wall) {
  std::vector<algorithm::Metric> metrics = RunMetrics(report);
  metrics.insert(metrics.end(), report.metrics.begin(), report.metrics.end());
  const std::vector<algorithm::Metric> of_wall = WallMetrics(report, wall);
  metrics.insert(metrics.end(), of_wall.begin(), of_wall.end());
  return metrics;
}

}  // namespace metronome::record
