#pragma once

#include <array>
#include <cstdint>

#include "common/messages/episode.h"
#include "common/numbers/elementary.h"

namespace metronome::policy {

inline constexpr float kHalfLogTwoPi = 0.918938533204672742F;

/// 1 / exp(log_std) of each component; the first `size` count.
inline std::array<float, kMaxActionSize> InverseStd(const float* log_std, std::int32_t size) {
  std::array<float, kMaxActionSize> inverse{};
  for (int i = 0; i < size; ++i) inverse[i] = 1 / numbers::Exp(log_std[i]);
  return inverse;
}

/// Log-density (nats) of a diagonal Gaussian over actions; every array is [size].
inline float GaussianLogProb(const float* action, const float* mean, const float* inv_std,
                             const float* log_std, std::int32_t size) {
  float log_prob = 0;
  for (int i = 0; i < size; ++i) {
    const float z = (action[i] - mean[i]) * inv_std[i];
    log_prob += -0.5F * z * z - log_std[i] - kHalfLogTwoPi;
  }
  return log_prob;
}

/// Entropy (nats) of the same distribution.
inline float GaussianEntropy(const float* log_std, std::int32_t size) {
  float entropy = 0;
  for (int i = 0; i < size; ++i) entropy += log_std[i] + 0.5F + kHalfLogTwoPi;
  return entropy;
}

}  // namespace metronome::policy
