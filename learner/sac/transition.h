#pragma once

#include <cstdint>

#include "common/schema/config.pb.h"
#include "learner/sac/replay.h"

namespace metronome::sac {

/// A step and what came of it: the discounted rewards of up to n steps, and the state after them.
struct Transition {
  ReplayStep step;
  std::int32_t head = 0;       // that acted
  float reward = 0;            // sum of discount^i times the reward of step t + i
  std::int32_t next_t = 0;     // steps taken before the state that is valued
  std::int32_t next_head = 0;  // that values it
  float next_discount = 0;     // of its value; 0: nothing comes after it
};

/// @param sac  resolved.
Transition TransitionAt(const ReplayStep& step, const SacConfig& sac);

}  // namespace metronome::sac
