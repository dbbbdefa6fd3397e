#include "learner/ppo/ppo_loss.h"

#include <algorithm>

#include "common/numbers/elementary.h"
#include "common/policy/gaussian.h"

namespace metronome::ppo {

PolicyLoss ComputePolicyLoss(const PolicySample& sample, const float* mean, const float* inv_std,
                             const float* log_std, std::int32_t size, float clip) {
  PolicyLoss result;
  result.log_ratio = policy::GaussianLogProb(sample.action, mean, inv_std, log_std, size) -
                     sample.proximal_log_prob;
  const float ratio = numbers::Exp(result.log_ratio);
  const float bounded = std::clamp(ratio, 1 - clip, 1 + clip);
  result.clipped = bounded != ratio;
  const float plain = ratio * sample.advantage;
  const float pessimistic = std::min(plain, bounded * sample.advantage);
  result.loss = -sample.behaviour_weight * pessimistic;
  // Where the clipped branch is the smaller one the objective is flat.
  if (plain > pessimistic) return result;
  const float d_log_prob = -sample.behaviour_weight * plain;
  for (std::int32_t i = 0; i < size; ++i) {
    const float z = (sample.action[i] - mean[i]) * inv_std[i];
    result.d_mean[i] = d_log_prob * z * inv_std[i];
    result.d_log_std[i] = d_log_prob * (z * z - 1);
  }
  return result;
}

}  // namespace metronome::ppo
