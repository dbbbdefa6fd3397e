#pragma once

#include <vector>

#include "common/messages/episode.h"
#include "common/schema/config.pb.h"

namespace metronome::algorithm {

/// The reward to learn from, as environment.reward names it, before any scaling. Where success is
/// reached by accident only, past states that are worth less than those before them, it must be
/// worth the way there. @return [T].
std::vector<float> LearningReward(const Episode& episode, const EnvironmentConfig& environment);

}  // namespace metronome::algorithm
