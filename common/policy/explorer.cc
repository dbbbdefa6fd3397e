#include "common/policy/explorer.h"

#include "common/numbers/random.h"

namespace metronome::policy {

Explorer::Explorer(const RunConfig& config, std::uint64_t number)
    : size_(config.environment().spec().action_size()),
      seed_(config.seed()),
      number_(number),
      uniform_(config.has_sac() && number < std::uint64_t(config.sac().random_episodes())),
      noise_(config, number) {}

Policy::Action Explorer::Uniform(std::int32_t t) const {
  numbers::RandomStream stream(numbers::RandomPurpose::kTrain, seed_, number_, std::uint64_t(t));
  Policy::Action action{};
  for (std::int32_t i = 0; i < size_; ++i) action[i] = float(2 * stream.Uniform() - 1);
  return action;
}

Policy::Decision Explorer::Act(Policy& policy, const HeadSchedule& schedule,
                               const float* observation, std::int32_t t) {
  if (uniform_) return policy.ActUniformly(schedule, t, Uniform(t));
  return policy.Act(schedule, observation, t, noise_.At(t));
}

Policy::Decision Explorer::ActAround(const Policy& policy, const HeadSchedule& schedule,
                                     const Policy::Gaussian& gaussian, std::int32_t t) {
  if (uniform_) return policy.ActUniformly(schedule, t, Uniform(t));
  return policy.ActAround(schedule, gaussian, t, noise_.At(t));
}

}  // namespace metronome::policy
