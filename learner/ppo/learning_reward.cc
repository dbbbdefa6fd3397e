#include "learner/ppo/learning_reward.h"

#include <cstddef>

namespace metronome::ppo {

std::vector<float> LearningReward(const Episode& episode, const PpoConfig& ppo) {
  const auto success_reward = static_cast<float>(ppo.success_reward());
  std::vector<float> rewards = episode.reward;
  for (std::size_t t = 0; t < rewards.size(); ++t) {
    if ((episode.flags[t] & kStepSuccess) != 0) rewards[t] += success_reward;
  }
  return rewards;
}

}  // namespace metronome::ppo
