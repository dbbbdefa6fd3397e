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

/// The N samples of one update, all steps of its E episodes, in episode and time order, ready for
/// the epochs.
struct TrainingBatch {
  kernels::Matrix input;                  // [N, network inputs], normalised
  kernels::Matrix action;                 // [N, A]
  std::vector<float> behaviour_log_prob;  // [N], as the actors said (and the check confirmed)
  std::vector<float> proximal_log_prob;   // [N], under the parameters at the update's start
  std::vector<float> behaviour_weight;    // [N], proximal over behaviour probability
  std::vector<float> value;               // [N], by the critic at the update's start
  std::vector<float> advantage;           // [N]
  std::vector<float> target;              // [N]
  std::vector<std::uint16_t> head;        // [N]
  double explained_variance = 0;          // of target by value

  [[nodiscard]] std::size_t size() const { return head.size(); }
};

struct BatchSource {
  const RunConfig& config;
  const std::vector<Episode>& episodes;  // in number order
  const PolicySnapshot& behaviour;       // its normaliser is the batch's
  const float* parameters;               // at the update's start: actor, then critic
  std::vector<float> reward_scale;       // [tasks], by which rewards are divided
};

/// @param team  shares out the episodes; never changes the result.
TrainingBatch BuildBatch(const BatchSource& source, network::WorkerTeam& team);

}  // namespace metronome::ppo
