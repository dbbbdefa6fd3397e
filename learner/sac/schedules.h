#pragma once

#include <cstdint>

#include "common/schema/config.pb.h"

namespace metronome::sac {

/// Gradient steps that are due once `steps` steps of the environment have been learnt from, in all.
/// @param config  resolved, as below.
std::uint64_t GradientStepsDue(std::uint64_t steps, const RunConfig& config);

/// What a gradient step's learning rates are of the first one's: sac.learning_rate_floor.
/// @param gradient_step  from 0, over the whole run.
double LearningRateShare(std::uint64_t gradient_step, const RunConfig& config);

/// Log of the standard deviation whose entropy the temperatures are led to in a gradient step:
/// sac.target_std and how it falls. @param gradient_step  as above.
double TargetLogStd(std::uint64_t gradient_step, const RunConfig& config);

}  // namespace metronome::sac
