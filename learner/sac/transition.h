#pragma once

#include <cstdint>
#include <vector>

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

/// The samples of one gradient step, sorted by head and then by next_head: equally many of each
/// head that acted in the replay, to one, each step of a head equally likely; but for
/// sac.success_share of them, which are of episodes with success if these have fewer steps than
/// that share.
/// @param gradient_step  counted from the run's first: with the seed the key of all draws.
std::vector<Transition> DrawBatch(const Replay& replay, const RunConfig& config,
                                  std::uint64_t gradient_step);

}  // namespace metronome::sac
