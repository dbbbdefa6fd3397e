#include "learner/algorithm/update_report.h"

#include <algorithm>

#include "common/policy/task_of.h"

namespace metronome::algorithm {

namespace {

/// Over episodes.
class Sums {
 public:
  void Add(const Episode& episode) {
    ++episodes_;
    for (const float reward : episode.reward) sums_.mean_return += reward;
    sums_.success += std::any_of(episode.flags.begin(), episode.flags.end(),
                                 [](std::uint8_t flags) { return (flags & kStepSuccess) != 0; });
    sums_.success_end += (episode.flags.back() & kStepSuccess) != 0;
  }

  [[nodiscard]] EpisodeFigures Means() const {
    const double episodes = std::max(episodes_, 1);  // none: zeros
    return {sums_.mean_return / episodes, sums_.success / episodes, sums_.success_end / episodes};
  }

 private:
  EpisodeFigures sums_;
  int episodes_ = 0;
};

}  // namespace

std::vector<TaskReport> TasksOf(const RunConfig& config) {
  std::vector<TaskReport> tasks;
  for (const std::string& name : config.environment().spec().tasks()) tasks.push_back({{}, name});
  return tasks;
}

checkpoint::RunCounters CountersAfter(const checkpoint::RunCounters& before,
                                      const std::vector<Episode>& batch) {
  checkpoint::RunCounters after = before;
  ++after.version;
  after.episodes_used += batch.size();
  for (const Episode& episode : batch) after.steps += std::uint64_t(episode.length());
  return after;
}

UpdateReport ReportOf(const RunConfig& config, const checkpoint::RunCounters& after,
                      const std::vector<Episode>& batch) {
  UpdateReport report;
  static_cast<checkpoint::RunCounters&>(report) = after;
  Sums all;
  std::vector<Sums> tasks(policy::TaskCount(config));
  for (const Episode& episode : batch) {
    all.Add(episode);
    tasks[policy::TaskOf(config, episode.number)].Add(episode);
  }
  static_cast<EpisodeFigures&>(report) = all.Means();
  report.tasks = TasksOf(config);
  for (std::size_t i = 0; i < report.tasks.size(); ++i)
    static_cast<EpisodeFigures&>(report.tasks[i]) = tasks[i].Means();
  return report;
}

}  // namespace metronome::algorithm
