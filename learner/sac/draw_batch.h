#pragma once

#include <cstdint>
#include <vector>

#include "common/schema/config.pb.h"
#include "learner/sac/replay.h"
#include "learner/sac/transition.h"

namespace metronome::sac {

/// The samples of one gradient step, sorted by head and then by next_head: equally many of each
/// head that acted in the replay, to one. Of a head's samples
/// - sac.success_share are of episodes with success, if these have fewer steps than that share;
/// - sac.best_share of the others are of episodes that were rewarded most: rank r of n among those
///   of a task has the probability ln(1 + 1/r) / ln(n + 1);
/// - of the rest each step of the head is equally likely.
/// @param gradient_step  counted from the run's first: with the seed the key of all draws.
std::vector<Transition> DrawBatch(const Replay& replay, const RunConfig& config,
                                  std::uint64_t gradient_step);

}  // namespace metronome::sac
