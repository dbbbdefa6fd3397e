#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/schema/config.pb.h"
#include "learner/ppo/training_batch.h"
#include "learner/ppo/worker_team.h"

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
};

struct StepSettings {
  double learning_rate = 0;
  double entropy_coefficient = 0;
};

/// One gradient step on one minibatch, on all threads of a team and with the same bits on any
/// number of them: the minibatch, sorted by head, is cut into fixed shards of kShardSamples; whole
/// shards make at most 64 groups (gradient_reducer.h); each group's gradient is computed alone,
/// shard by shard in order; groups are summed in order.
class MinibatchStep {
 public:
  static constexpr std::size_t kShardSamples = 128;

  MinibatchStep(const RunConfig& config, WorkerTeam& team);
  ~MinibatchStep();

  /// @param samples  indices into `batch`, in any order.
  /// @throws NonFiniteUpdate (learner/algorithm/algorithm.h) if the gradient is not finite;
  ///         `state` is then unchanged.
  MinibatchSums Run(const TrainingBatch& batch, const std::vector<std::uint32_t>& samples,
                    const StepSettings& settings, OptimiserState& state);

  /// Gradient of the last minibatch's loss, before clipping: actor, then critic.
  [[nodiscard]] const std::vector<float>& gradient() const;

  /// Whole gradients in memory, one a group, beside gradient().
  [[nodiscard]] std::size_t gradients_held() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace metronome::ppo
