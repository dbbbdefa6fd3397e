#pragma once

#include <array>
#include <cstddef>

#include "learner/network/mlp.h"
#include "learner/network/worker_team.h"
#include "learner/sac/optimiser_state.h"
#include "learner/sac/sac_networks.h"

namespace metronome::sac {

/// Actor, critics and targets as a gradient step computes with them.
struct StepNetworks {
  /// @param samples  of a gradient step.
  StepNetworks(const SacNetworks& networks, std::size_t samples);

  /// Takes all parameters.
  void Pack(const OptimiserState& state, network::WorkerTeam& team);

  network::Mlp actor;
  std::array<network::Mlp, kCritics> critics;
  std::array<network::Mlp, kCritics> targets;
};

}  // namespace metronome::sac
