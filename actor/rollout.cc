#include "actor/rollout.h"

#include <array>
#include <cstddef>
#include <vector>

#include "actor/metaworld/placement.h"
#include "actor/metaworld/task_table.h"
#include "common/policy.h"
#include "common/random.h"

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
  const std::int32_t horizon = config.environment().horizon();
  Policy policy(config, snapshot);
  Episode episode = EmptyEpisode(number, snapshot.version, static_cast<std::size_t>(horizon));
  AppendObservation(environment.Reset(TrainingPlacement(config, number)), episode);
  for (std::int32_t t = 0; t < horizon; ++t) {
    if (cancel.load(std::memory_order_relaxed)) return std::nullopt;
    const float* observation = episode.observation.data() + std::size_t(t) * kObservationSize;
    const Policy::Decision decision =
        policy.Act(observation, t, ActionNoise(config.seed(), number, t));
    const metaworld::StepResult step = environment.Step(decision.action);
    episode.action.insert(episode.action.end(), decision.action.begin(), decision.action.end());
    episode.log_prob.push_back(decision.log_prob);
    episode.reward.push_back(static_cast<float>(step.reward));
    episode.head.push_back(static_cast<std::uint16_t>(decision.head));
    const int flags =
        (step.info.success ? kStepSuccess : 0) | (t + 1 == horizon ? kStepTruncated : 0);
    episode.flags.push_back(static_cast<std::uint8_t>(flags));
    AppendObservation(step.observation, episode);
  }
  return episode;
}

}  // namespace metronome
