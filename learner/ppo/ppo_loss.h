#pragma once

#include <array>
#include <cstdint>

#include "common/messages/episode.h"

namespace metronome::ppo {

/// One sample for the clipped objective, without the policy's current output.
struct PolicySample {
  const float* action = nullptr;  // [size], unclipped
  float proximal_log_prob = 0;    // under the parameters at the start of the update
  float behaviour_weight = 1;     // pi_proximal / pi_behaviour; 1 without overlap
  float advantage = 0;            // normalised
};

/// Loss of one sample and its derivatives.
struct PolicyLoss {
  float loss = 0;                              // -weight * min(r A, clip(r, 1 - c, 1 + c) A)
  float log_ratio = 0;                         // new minus proximal log-probability
  bool clipped = false;                        // r left [1 - c, 1 + c]
  std::array<float, kMaxActionSize> d_mean{};  // the first `size` of both count
  std::array<float, kMaxActionSize> d_log_std{};
};

/// Decoupled PPO objective (Hilton et al., arXiv:2110.00641, eq. 2): importance weight towards the
/// behaviour policy, clip around the proximal one. With equal policies it is PPO's clipped
/// surrogate (Schulman et al., arXiv:1707.06347, eq. 7).
/// @param size                of an action.
/// @param mean, inv_std, log_std  [size] of the sample's head under the current parameters.
PolicyLoss ComputePolicyLoss(const PolicySample& sample, const float* mean, const float* inv_std,
                             const float* log_std, std::int32_t size, float clip);

}  // namespace metronome::ppo
