#pragma once

#include <vector>

#include "common/messages/episode.h"
#include "common/schema/config.pb.h"

namespace metronome::ppo {

/// The reward to learn from, before it is scaled: the environment's, and ppo.success_reward more
/// after each step with success. Where success is reached by accident only, past states that are
/// worth less than those before them, it must be worth the way there. @return [T].
std::vector<float> LearningReward(const Episode& episode, const PpoConfig& ppo);

}  // namespace metronome::ppo
