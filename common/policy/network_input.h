#pragma once

#include <algorithm>
#include <cstdint>

#include "common/policy/network.h"

namespace metronome::policy {

/// Writes the network's input for one observation: normalised, clipped to +-clip, and - where the
/// shape asks for it - the time 2t/T-1. Actor and learner share it, so both see equal bits.
/// @param observation  [shape.observation], mean and inv_std alike.
/// @param t            steps taken, 0..horizon.
/// @param input        [shape.input()], written.
inline void WriteInput(const NetworkShape& shape, const float* observation, const float* mean,
                       const float* inv_std, float clip, std::int32_t t, std::int32_t horizon,
                       float* input) {
  for (std::int32_t i = 0; i < shape.observation; ++i) {
    input[i] = std::clamp((observation[i] - mean[i]) * inv_std[i], -clip, clip);
  }
  if (shape.time_feature) {
    input[shape.observation] = 2.0F * static_cast<float>(t) / static_cast<float>(horizon) - 1.0F;
  }
}

}  // namespace metronome::policy
