#include "learner/algorithm/update_report.h"

#include <algorithm>

namespace metronome::algorithm {

checkpoint::RunCounters CountersAfter(const checkpoint::RunCounters& before,
                                      const std::vector<Episode>& batch) {
  checkpoint::RunCounters after = before;
  ++after.version;
  after.episodes_used += batch.size();
  for (const Episode& episode : batch) after.steps += std::uint64_t(episode.length());
  return after;
}

UpdateReport ReportOf(const checkpoint::RunCounters& after, const std::vector<Episode>& batch) {
  UpdateReport report;
  static_cast<checkpoint::RunCounters&>(report) = after;
  for (const Episode& episode : batch) {
    for (const float reward : episode.reward) report.mean_return += reward;
    report.success += std::any_of(episode.flags.begin(), episode.flags.end(),
                                  [](std::uint8_t flags) { return (flags & kStepSuccess) != 0; });
    report.success_end += (episode.flags.back() & kStepSuccess) != 0;
  }
  const auto episodes = double(batch.size());
  report.mean_return /= episodes;
  report.success /= episodes;
  report.success_end /= episodes;
  return report;
}

}  // namespace metronome::algorithm
