#pragma once

#include <cstdint>
#include <vector>

#include "common/schema/config.pb.h"
#include "learner/network/adam.h"
#include "learner/network/shared_heads.h"
#include "learner/network/worker_team.h"
#include "learner/sac/head_sums.h"
#include "learner/sac/optimiser_state.h"
#include "learner/sac/step_networks.h"

namespace metronome::sac {

/// Steps along gradients, by Adam: parameters move, and the networks take them. The step in work is
/// the last that the state counts.
class Descent {
 public:
  /// @param config  resolved. @param networks, team  outlive this.
  Descent(const RunConfig& config, StepNetworks& networks, network::WorkerTeam& team);

  /// The critics, by the gradient of both [2 * critic's size], then the targets towards them.
  /// @param norm  of the gradient: above sac.max_gradient_norm it is scaled down to that.
  void Critics(const std::vector<float>& gradient, double norm, OptimiserState& state) const;

  /// The policy. See Critics.
  void Actor(const std::vector<float>& gradient, double norm, OptimiserState& state) const;

  /// Of ln(temperature) * (entropy - wanted entropy), the means over each head's samples. A head
  /// without samples stays.
  void Temperatures(const std::vector<HeadSums>& sums, OptimiserState& state) const;

 private:
  [[nodiscard]] double RateNow(double first_rate, const OptimiserState& state) const;
  [[nodiscard]] network::Adam AdamOf(double first_rate, double norm,
                                     const OptimiserState& state) const;
  [[nodiscard]] float HeadsDecay(double first_rate, const OptimiserState& state) const;
  void Follow(std::size_t first, std::size_t count, OptimiserState& state) const;

  RunConfig config_;
  SacConfig sac_;
  std::size_t actions_;
  StepNetworks& networks_;
  network::WorkerTeam& team_;
  network::SharedHeads actor_heads_;
  network::SharedHeads critic_heads_;
};

}  // namespace metronome::sac
