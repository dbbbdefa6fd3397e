#pragma once

#include <cstdint>
#include <vector>

#include "common/kernels/matrix.h"
#include "common/messages/episode.h"
#include "common/messages/messages.h"
#include "common/policy/network.h"
#include "common/schema/config.pb.h"
#include "learner/network/worker_team.h"

namespace metronome::ppo {

/// What a part of the reward is worth in each sample, [N] each.
struct ValuedReward {
  std::vector<float> value;  // by the critic at the update's start
  std::vector<float> advantage;
  std::vector<float> target;
};

/// The N samples of one update, all steps of its episodes, in episode and time order, ready for the
/// epochs.
struct TrainingBatch {
  kernels::Matrix input;                  // [N, network inputs], normalised
  kernels::Matrix action;                 // [N, A]
  std::vector<float> behaviour_log_prob;  // [N], as the actors said (and the check confirmed)
  std::vector<float> proximal_log_prob;   // [N], under the parameters at the update's start
  std::vector<float> behaviour_weight;    // [N], proximal over behaviour probability
  std::vector<ValuedReward> rewards;  // [shape.values]: of the reward, or the official and success
  std::vector<float> advantage;       // [N], of all parts of the reward together
  std::vector<std::uint16_t> head;    // [N]
  double explained_variance = 0;      // of the first part's target by its value

  [[nodiscard]] std::size_t size() const { return head.size(); }
};

struct BatchSource {
  const RunConfig& config;
  const std::vector<Episode>& episodes;  // in number order
  std::size_t earlier = 0;               // of these, the first so many are of batches before
  const PolicySnapshot& behaviour;       // its normaliser is the batch's
  const float* parameters;               // at the update's start: actor, then critic
  std::vector<float> reward_scale;       // [tasks, values], by which rewards are divided
};

/// Parts of the reward to learn from, [shape.values, T]: that reward, or the official one and 1 a
/// step with success (ppo.success_weight).
std::vector<std::vector<float>> RewardParts(const Episode& episode, const RunConfig& config);

/// Advantages of two parts are added as ppo.success_weight says: the official reward's, divided by
/// their root mean square, and the weight times those of success, in units of their returns' scale.
/// In these a success that is rare is large, and without any the part is next to nothing. Values
/// and scales apart: Burda et al., arXiv:1810.12894, section 2.3 (there a bonus for novelty).
///
/// Episodes of earlier batches are valued as the batch's own. Their importance weights are cut off
/// at kLargestWeight (Queeney et al., arXiv:2111.00072, learn from several policies' batches; the
/// cut: Espeholt et al., arXiv:1802.01561, equation 1).
inline constexpr float kLargestWeight = 2;

/// @param team  shares out the episodes; never changes the result.
TrainingBatch BuildBatch(const BatchSource& source, network::WorkerTeam& team);

}  // namespace metronome::ppo
