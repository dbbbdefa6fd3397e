#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/numbers/elementary.h"
#include "common/policy/gaussian.h"

/// A Gaussian whose draw u becomes the action tanh(u), with standard deviations of the state: SAC's
/// policy (Haarnoja et al., arXiv:1812.05905, appendix C). Actors, the learner's check and its
/// update share these functions, so all see equal bits.
namespace metronome::policy {

/// Between these a log-std is. Source: CleanRL's SAC.
inline constexpr float kLeastLogStd = -5;
inline constexpr float kMostLogStd = 2;

/// tanh(x), within 1 ulp of float.
inline float Squash(float x) { return float(1 - 2 / (numbers::Exp(2 * double{x}) + 1)); }

/// The log-std that a network's output stands for.
inline float SquashedLogStd(float output) {
  return kLeastLogStd + 0.5F * (kMostLogStd - kLeastLogStd) * (Squash(output) + 1);
}

/// ln(1 - tanh(u)^2) = 2 (ln 2 - u - softplus(-2 u)), which no u makes infinite.
inline float LogSquashSlope(float u) {
  constexpr double kLogTwo = 0.693147180559945309;
  const double a = -2 * std::abs(double{u});
  return float(2 * (kLogTwo + 0.5 * a - numbers::Log(1 + numbers::Exp(a))));
}

/// Draws action = tanh(mean + std * noise). Every array is [size]. @return its log-density, nats.
inline float DrawSquashed(const float* mean, const float* log_std, const float* noise,
                          std::int32_t size, float* action) {
  float log_prob = 0;
  for (std::int32_t i = 0; i < size; ++i) {
    const float u = mean[i] + numbers::Exp(log_std[i]) * noise[i];
    action[i] = Squash(u);
    log_prob += -0.5F * noise[i] * noise[i] - log_std[i] - kHalfLogTwoPi - LogSquashSlope(u);
  }
  return log_prob;
}

}  // namespace metronome::policy
