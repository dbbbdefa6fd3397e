#pragma once

#include <vector>

#include "common/messages/episode.h"
#include "common/schema/config.pb.h"

namespace metronome::algorithm {

/// The reward to learn from, as environment.reward names it, before any scaling. Where success is
/// reached by accident only, past states that are worth less than those before them, it must be
/// worth the way there. @return [T].
std::vector<float> LearningReward(const Episode& episode, const EnvironmentConfig& environment);

/// Whether the time after the last step is worth the value of the final observation, or nothing. An
/// episode that was cut short would have gone on: its end says nothing of what comes.
/// @param at_limit  what it is worth after the horizon's last step.
bool FinalStateCounts(const Episode& episode, const EnvironmentConfig& environment,
                      TimeLimitValue at_limit);

}  // namespace metronome::algorithm
