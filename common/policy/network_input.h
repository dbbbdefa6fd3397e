#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "common/policy/network.h"

namespace metronome::policy {

/// The normaliser of observations of several tasks: mean and 1/std, [tasks, observation].
struct Normaliser {
  const float* mean;
  const float* inv_std;
  float clip;
};

/// Time as a network sees it, from -1 to 1.
inline float Phase(std::int32_t t, std::int32_t horizon) {
  return 2.0F * static_cast<float>(t) / static_cast<float>(horizon) - 1.0F;
}

/// Writes the network's input for one observation: normalised by the task's statistics, clipped to
/// +-clip, and - where the shape asks for it - the task's one-hot and the time 2t/T-1. Actor and
/// learner share it, so both see equal bits.
/// @param observation  [shape.observation].
/// @param task         0 .. shape.tasks - 1.
/// @param t            steps taken, 0..horizon.
/// @param input        [shape.input()], written.
inline void WriteInput(const NetworkShape& shape, const Normaliser& normaliser,
                       const float* observation, std::size_t task, std::int32_t t,
                       std::int32_t horizon, float* input) {
  const std::size_t first = task * std::size_t(shape.observation);
  const float* mean = normaliser.mean + first;
  const float* inv_std = normaliser.inv_std + first;
  for (std::int32_t i = 0; i < shape.observation; ++i) {
    input[i] =
        std::clamp((observation[i] - mean[i]) * inv_std[i], -normaliser.clip, normaliser.clip);
  }
  if (shape.task_onehot) {
    std::fill_n(input + shape.observation, shape.tasks, 0.0F);
    input[std::size_t(shape.observation) + task] = 1;
  }
  if (shape.time_feature) {
    input[shape.input() - 1] = Phase(t, horizon);
  }
}

}  // namespace metronome::policy
