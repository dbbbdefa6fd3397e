#include "learner/ppo/gae.h"

#include <cstddef>
#include <stdexcept>

namespace metronome::ppo {

GaeResult ComputeGae(const std::vector<float>& reward, const std::vector<float>& value,
                     float final_value, const GaeParameters& parameters) {
  if (reward.size() != value.size()) {
    throw std::invalid_argument("GAE needs as many values as rewards");
  }
  GaeResult result;
  result.advantage.resize(reward.size());
  result.target.resize(reward.size());
  double next_value = final_value;
  double advantage = 0;
  for (std::size_t t = reward.size(); t-- > 0;) {
    const double delta = reward[t] + parameters.discount * next_value - value[t];
    advantage = delta + parameters.discount * parameters.lambda * advantage;
    next_value = value[t];
    result.advantage[t] = static_cast<float>(advantage);
    result.target[t] = static_cast<float>(advantage + value[t]);
  }
  return result;
}

}  // namespace metronome::ppo
