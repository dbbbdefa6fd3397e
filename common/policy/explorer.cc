#include "common/policy/explorer.h"

#include <cmath>

#include "common/numbers/elementary.h"
#include "common/numbers/random.h"

namespace metronome::policy {
namespace {

// spread^x, x in [-1, 1): multiples of the golden ratio, modulo 1, fill an interval evenly.
float NoiseScale(const RunConfig& config, std::uint64_t number) {
  if (!config.has_sac()) return 1;
  const double turns = double(number) * 0.6180339887498949;
  const double x = 2 * (turns - std::floor(turns)) - 1;
  return float(numbers::Exp(x * numbers::Log(config.sac().noise_spread())));
}

}  // namespace

Explorer::Explorer(const RunConfig& config, std::uint64_t number)
    : size_(config.environment().spec().action_size()),
      seed_(config.seed()),
      number_(number),
      uniform_(config.has_sac() && number < std::uint64_t(config.sac().random_episodes())),
      scale_(NoiseScale(config, number)),
      noise_(config, number) {}

ActionNoise::Numbers Explorer::Noise(std::int32_t t) {
  ActionNoise::Numbers noise = noise_.At(t);
  for (float& number : noise) number *= scale_;
  return noise;
}

Policy::Action Explorer::Uniform(std::int32_t t) const {
  numbers::RandomStream stream(numbers::RandomPurpose::kTrain, seed_, number_, std::uint64_t(t));
  Policy::Action action{};
  for (std::int32_t i = 0; i < size_; ++i) action[i] = float(2 * stream.Uniform() - 1);
  return action;
}

Policy::Decision Explorer::Act(Policy& policy, const HeadSchedule& schedule,
                               const float* observation, std::int32_t t) {
  if (uniform_) return policy.ActUniformly(schedule, t, Uniform(t));
  return policy.Act(schedule, observation, t, Noise(t));
}

Policy::Decision Explorer::ActAround(const Policy& policy, const HeadSchedule& schedule,
                                     const Policy::Gaussian& gaussian, std::int32_t t) {
  if (uniform_) return policy.ActUniformly(schedule, t, Uniform(t));
  return policy.ActAround(schedule, gaussian, t, Noise(t));
}

}  // namespace metronome::policy
