#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/messages/messages.h"
#include "common/schema/config.pb.h"
#include "learner/network/worker_team.h"
#include "learner/sac/head_sums.h"
#include "learner/sac/optimiser_state.h"
#include "learner/sac/transition.h"

namespace metronome::sac {

/// Figures of one gradient step, means over its batch.
struct StepFigures {
  double critic_loss = 0;  // cross-entropy, mean of both critics
  double actor_loss = 0;
  double critic_gradient_norm = 0;  // of both critics, before clipping
  double actor_gradient_norm = 0;
  std::vector<HeadSums> heads;  // [heads]
};

/// One gradient step of multi-head SAC (Haarnoja et al., arXiv:1812.05905, algorithm 1) on one
/// batch, on all threads of a team and with the same bits on any number of them. In this order: the
/// critics towards the targets' values of the policy's own next actions; the targets towards the
/// critics; the policy up the lesser critic and its own entropy; the temperatures towards the
/// entropy wanted.
///
/// Three things are not the paper's: values are distributions over bins of symlog (value_bins.h),
/// so the temperature weighs entropy against symlog values; the entropy of later actions is no part
/// of a value (which has another unit); and actor, critics and temperatures have a head each for
/// the blocks of time: head(t) acts and is valued, head(t + n) gives the target's action and value.
class GradientStep {
 public:
  GradientStep(const RunConfig& config, network::WorkerTeam& team);
  ~GradientStep();

  /// Takes the parameters that the first Run starts from.
  void Begin(const OptimiserState& state);

  /// @param batch       sorted as DrawBatch does, sac.batch samples.
  /// @param normaliser  whose observation statistics the networks see by.
  /// @param state       as the Run before left it, or Begin was given it.
  /// @throws NonFiniteUpdate (learner/algorithm/algorithm.h) if a gradient is not finite.
  StepFigures Run(const std::vector<Transition>& batch, const PolicySnapshot& normaliser,
                  OptimiserState& state);

  /// Of the last Run, before clipping: of the mean losses of both critics, and of the policy.
  [[nodiscard]] const std::vector<float>& critic_gradient() const;
  [[nodiscard]] const std::vector<float>& actor_gradient() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace metronome::sac
