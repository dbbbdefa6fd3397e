#include "learner/ppo/initialise.h"

#include <algorithm>
#include <cstddef>

#include "learner/network/initialise.h"

namespace metronome::ppo {

std::vector<float> InitialParameters(const policy::NetworkShape& shape, double log_std,
                                     std::uint64_t seed) {
  network::Initialiser initialiser(seed);
  const policy::MlpLayout actor = policy::ActorLayout(shape);
  std::vector<float> parameters = initialiser.Network(actor, 0.01);
  std::fill(parameters.begin() + static_cast<std::ptrdiff_t>(actor.log_std), parameters.end(),
            static_cast<float>(log_std));
  const std::vector<float> critic = initialiser.Network(policy::CriticLayout(shape), 1.0);
  parameters.insert(parameters.end(), critic.begin(), critic.end());
  return parameters;
}

}  // namespace metronome::ppo
