#include "learner/algorithm/learning_reward.h"

#include <cstddef>

namespace metronome::algorithm {

std::vector<float> LearningReward(const Episode& episode, const EnvironmentConfig& environment) {
  std::vector<float> rewards = episode.reward;
  if (environment.reward() != REWARD_SUCCESS) return rewards;
  const auto success_reward = static_cast<float>(environment.success_reward());
  for (std::size_t t = 0; t < rewards.size(); ++t) {
    if ((episode.flags[t] & kStepSuccess) != 0) rewards[t] += success_reward;
  }
  return rewards;
}

bool FinalStateCounts(const Episode& episode, const EnvironmentConfig& environment,
                      TimeLimitValue at_limit) {
  if ((episode.flags.back() & kStepTerminated) != 0) return false;
  return episode.length() < environment.horizon() || at_limit == BOOTSTRAP;
}

}  // namespace metronome::algorithm
