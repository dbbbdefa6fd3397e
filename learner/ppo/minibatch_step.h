#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "common/schema/config.pb.h"
#include "learner/network/shared_heads.h"
#include "learner/network/worker_team.h"
#include "learner/ppo/training_batch.h"

namespace metronome::ppo {

/// Sums over the samples of one head.
struct HeadSums {
  double samples = 0;
  double kl = 0;       // old minus new log-probability
  double clipped = 0;  // samples whose ratio left the clip range
};

/// Sums over the samples of one minibatch.
struct MinibatchSums {
  double policy_loss = 0;
  double value_loss = 0;  // half squared error
  double entropy = 0;
  double gradient_norm = 0;     // of the minibatch's mean loss, before clipping
  std::vector<HeadSums> heads;  // [k]
};

struct OptimiserState {
  std::vector<float> parameters;  // actor, then critic
  std::vector<float> adam_m;
  std::vector<float> adam_v;
  std::uint64_t adam_steps = 0;
  network::SharedHeads::Moments shared;  // empty without ppo.shared_heads
};

struct StepSettings {
  double learning_rate = 0;
  double entropy_coefficient = 0;
  // Between these all log-stds are after the step.
  double min_log_std = -std::numeric_limits<double>::infinity();
  double max_log_std = std::numeric_limits<double>::infinity();
};

/// One gradient step on one minibatch, on all threads of a team and with the same bits on any
/// number of them. The samples are sorted by head; passes take a few dozen of them at a time,
/// gradients a few thousand parameters, each summed over the samples by the rule of mlp.h.
class MinibatchStep {
 public:
  MinibatchStep(const RunConfig& config, network::WorkerTeam& team);
  ~MinibatchStep();

  /// Takes the parameters that the first Run starts from.
  void Begin(const OptimiserState& state);

  /// @param samples  indices into `batch`, in any order, at most a minibatch.
  /// @param state    as the Run before left it, or Begin was given it.
  /// @throws NonFiniteUpdate (learner/algorithm/algorithm.h) if the gradient is not finite;
  ///         `state` is then unchanged.
  MinibatchSums Run(const TrainingBatch& batch, const std::vector<std::uint32_t>& samples,
                    const StepSettings& settings, OptimiserState& state);

  /// Gradient of the last minibatch's loss, before clipping: actor, then critic.
  [[nodiscard]] const std::vector<float>& gradient() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace metronome::ppo
