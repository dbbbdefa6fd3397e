#include "actor/play/rollout.h"

#include <array>
#include <chrono>
#include <cstddef>
#include <vector>

#include "actor/metaworld/placement.h"
#include "actor/metaworld/tasks/task_table.h"
#include "common/numbers/random.h"
#include "common/policy/action_noise.h"
#include "common/policy/head_schedule.h"
#include "common/policy/policy.h"
#include "common/process/cpu_times.h"

namespace metronome {
namespace {

void AppendObservation(const metaworld::Observation& observation, Episode& episode) {
  for (const double value : observation) episode.observation.push_back(static_cast<float>(value));
}

Episode EmptyEpisode(std::uint64_t number, std::uint64_t version, std::size_t horizon) {
  Episode episode;
  episode.number = number;
  episode.weights_version = version;
  episode.observation.reserve((horizon + 1) * kObservationSize);
  episode.action.reserve(horizon * kActionSize);
  episode.log_prob.reserve(horizon);
  episode.reward.reserve(horizon);
  episode.head.reserve(horizon);
  episode.flags.reserve(horizon);
  return episode;
}

void AppendStep(const Policy::Decision& decision, const metaworld::StepResult& step, bool last,
                Episode& episode) {
  episode.action.insert(episode.action.end(), decision.action.begin(), decision.action.end());
  episode.log_prob.push_back(decision.log_prob);
  episode.reward.push_back(static_cast<float>(step.reward));
  episode.head.push_back(static_cast<std::uint16_t>(decision.head));
  const int flags = (step.info.success ? kStepSuccess : 0) | (last ? kStepTruncated : 0);
  episode.flags.push_back(static_cast<std::uint8_t>(flags));
  AppendObservation(step.observation, episode);
}

/// Shares out an episode's CPU time in proportion to the wall-clock time between laps: CPU time
/// itself takes a system call, wall-clock time none.
class Stopwatch {
 public:
  using Clock = std::chrono::steady_clock;

  void Lap(CpuUse use) {
    const Clock::time_point now = Clock::now();
    laps_[static_cast<std::size_t>(use)] += now - last_;
    last_ = now;
  }

  void Count() const {
    const double share =
        (ThreadCpuSeconds() - cpu_begin_) / std::chrono::duration<double>(last_ - begin_).count();
    for (std::size_t use = 0; use < laps_.size(); ++use) {
      CpuTimes::OfProcess().Add(CpuUse(use),
                                share * std::chrono::duration<double>(laps_[use]).count());
    }
  }

 private:
  const double cpu_begin_ = ThreadCpuSeconds();
  const Clock::time_point begin_ = Clock::now();
  Clock::time_point last_ = begin_;
  std::array<Clock::duration, static_cast<std::size_t>(CpuUse::kCount)> laps_{};
};

}  // namespace

metaworld::RandVec TrainingPlacement(const RunConfig& config, std::uint64_t number) {
  const metaworld::TaskSpec& task = metaworld::FindTask(config.environment().task());
  const Placements mode = config.environment().placements();
  const std::uint64_t drawn = mode == PLACEMENTS_FIXED ? 0 : number;
  RandomStream stream(RandomPurpose::kTrain, config.seed(), drawn, kPlacementDraw);
  if (mode != PLACEMENTS_MT1) return metaworld::DrawPlacement(task, stream);
  const std::vector<metaworld::RandVec> official =
      metaworld::Mt1Placements(task, static_cast<std::uint32_t>(config.seed()));
  return official.at(stream.Below(official.size()));
}

std::optional<Episode> PlayEpisode(const RunConfig& config, const PolicySnapshot& snapshot,
                                   std::uint64_t number, metaworld::Environment& environment,
                                   const std::atomic<bool>& cancel) {
  Stopwatch stopwatch;
  const std::int32_t horizon = config.environment().horizon();
  Policy policy(config, snapshot);
  const HeadSchedule schedule(config, TrainingEpisode(config, number));
  ActionNoise noise(config, number);
  Episode episode = EmptyEpisode(number, snapshot.version, static_cast<std::size_t>(horizon));
  stopwatch.Lap(CpuUse::kPolicy);
  AppendObservation(environment.Reset(TrainingPlacement(config, number)), episode);
  stopwatch.Lap(CpuUse::kReset);
  for (std::int32_t t = 0; t < horizon; ++t) {
    if (cancel.load(std::memory_order_relaxed)) return std::nullopt;
    const float* observation = episode.observation.data() + std::size_t(t) * kObservationSize;
    const Policy::Decision decision = policy.Act(schedule, observation, t, noise.At(t));
    stopwatch.Lap(CpuUse::kPolicy);
    const metaworld::StepResult step = environment.Step(decision.action);
    stopwatch.Lap(CpuUse::kPhysics);
    AppendStep(decision, step, t + 1 == horizon, episode);
    stopwatch.Lap(CpuUse::kRollout);
  }
  stopwatch.Count();
  return episode;
}

}  // namespace metronome
