#include "learner/sac/descent.h"

#include <algorithm>

#include "common/numbers/elementary.h"
#include "common/policy/gaussian.h"
#include "learner/sac/schedules.h"

namespace metronome::sac {
namespace {

using network::Mlp;

// task(first, count) of the numbers of a part, behind `offset`.
template <typename Task>
void ForRanges(const Mlp& mlp, std::size_t part, std::size_t offset, const Task& task) {
  for (const network::ParameterRange& range : mlp.RangesOf(part)) {
    task(offset + range.first, range.count);
  }
}

}  // namespace

Descent::Descent(const RunConfig& config, StepNetworks& networks, network::WorkerTeam& team)
    : config_(config),
      sac_(config.sac()),
      actions_(SacNetworks(config).actions()),
      networks_(networks),
      team_(team),
      actor_heads_({networks.actor.layout()}),
      critic_heads_({networks.critics[0].layout(), networks.critics[1].layout()}) {}

double Descent::RateNow(double first_rate, const OptimiserState& state) const {
  return first_rate * LearningRateShare(state.gradient_steps - 1, config_);
}

network::Adam Descent::AdamOf(double first_rate, double norm, const OptimiserState& state) const {
  network::AdamStep adam;
  adam.learning_rate = float(RateNow(first_rate, state));
  adam.epsilon = float(sac_.adam_epsilon());
  adam.step = state.gradient_steps;
  adam.gradient_scale = float(std::min(1.0, sac_.max_gradient_norm() / (norm + 1e-6)));
  return network::Adam(adam);
}

float Descent::HeadsDecay(double first_rate, const OptimiserState& state) const {
  return float(std::min(1.0, RateNow(first_rate, state) * sac_.shared_heads_decay()));
}

// target += rate * (critic - target)
void Descent::Follow(std::size_t first, std::size_t count, OptimiserState& state) const {
  const auto rate = float(sac_.target_rate());
  for (std::size_t i = first; i < first + count; ++i) {
    state.targets[i] += rate * (state.critics[i] - state.targets[i]);
  }
}

void Descent::Critics(const std::vector<float>& gradient, double norm,
                      OptimiserState& state) const {
  const network::Adam adam = AdamOf(sac_.critic_learning_rate(), norm, state);
  auto& critics = networks_.critics;
  const std::size_t size = critics[0].layout().size;
  const std::size_t parts = critics[0].weight_parts();
  team_.Run(kCritics * parts, [&](std::size_t i) {
    ForRanges(critics[i / parts], i % parts, i / parts * size,
              [&](std::size_t at, std::size_t count) {
                adam.Apply(gradient.data() + at, state.critics.data() + at,
                           state.of_critics.m.data() + at, state.of_critics.v.data() + at, count);
              });
  });
  if (sac_.shared_heads()) {
    critic_heads_.Step(adam, gradient.data(), HeadsDecay(sac_.critic_learning_rate(), state),
                       state.of_critic_heads, state.critics.data());
  }
  team_.Run(kCritics * parts, [&](std::size_t i) {
    const std::size_t offset = i / parts * size;
    ForRanges(critics[i / parts], i % parts, offset,
              [&](std::size_t at, std::size_t count) { Follow(at, count, state); });
    critics[i / parts].Pack(i % parts, state.critics.data() + offset);
    networks_.targets[i / parts].Pack(i % parts, state.targets.data() + offset);
  });
}

void Descent::Actor(const std::vector<float>& gradient, double norm, OptimiserState& state) const {
  const network::Adam adam = AdamOf(sac_.actor_learning_rate(), norm, state);
  Mlp& actor = networks_.actor;
  team_.Run(actor.weight_parts(), [&](std::size_t part) {
    ForRanges(actor, part, 0, [&](std::size_t at, std::size_t count) {
      adam.Apply(gradient.data() + at, state.actor.data() + at, state.of_actor.m.data() + at,
                 state.of_actor.v.data() + at, count);
    });
  });
  if (sac_.shared_heads()) {
    actor_heads_.Step(adam, gradient.data(), HeadsDecay(sac_.actor_learning_rate(), state),
                      state.of_actor_heads, state.actor.data());
  }
  team_.Run(actor.weight_parts(), [&](std::size_t part) { actor.Pack(part, state.actor.data()); });
}

void Descent::Temperatures(const std::vector<HeadSums>& sums, OptimiserState& state) const {
  const network::Adam adam = AdamOf(sac_.temperature_learning_rate(), 0, state);
  const double log_std = TargetLogStd(state.gradient_steps - 1, config_);
  const double of_gaussian = 0.5 + double{policy::kHalfLogTwoPi} + log_std;
  const double wanted = double(actions_) * of_gaussian;
  for (std::size_t head = 0; head < sums.size(); ++head) {
    if (sums[head].samples == 0) continue;
    const auto gradient = float(sums[head].entropy / sums[head].samples - wanted);
    adam.Apply(&gradient, &state.log_temperature[head], &state.of_log_temperature.m[head],
               &state.of_log_temperature.v[head], 1);
  }
}

}  // namespace metronome::sac
