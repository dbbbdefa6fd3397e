#include "learner/sac/step_networks.h"

namespace metronome::sac {
namespace {

using network::Mlp;

Mlp Critic(const SacNetworks& networks, std::size_t samples) {
  return {networks.critic, samples, networks.actions()};
}

Mlp Target(const SacNetworks& networks, std::size_t samples) {
  return {networks.critic, samples, 0, false};
}

}  // namespace

StepNetworks::StepNetworks(const SacNetworks& networks, std::size_t samples)
    : actor(networks.actor, samples),
      critics{Critic(networks, samples), Critic(networks, samples)},
      targets{Target(networks, samples), Target(networks, samples)} {}

void StepNetworks::Pack(const OptimiserState& state, network::WorkerTeam& team) {
  const std::size_t of_actor = actor.weight_parts();
  const std::size_t parts = critics[0].weight_parts();
  team.Run(of_actor + kCritics * parts, [&](std::size_t i) {
    if (i < of_actor) return actor.Pack(i, state.actor.data());
    const std::size_t of = (i - of_actor) / parts;
    const std::size_t offset = of * critics[of].layout().size;
    critics[of].Pack((i - of_actor) % parts, state.critics.data() + offset);
    targets[of].Pack((i - of_actor) % parts, state.targets.data() + offset);
  });
}

}  // namespace metronome::sac
