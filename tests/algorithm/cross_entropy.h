#pragma once

#include <memory>

#include "learner/algorithm/algorithm_factory.h"

namespace metronome::test {

/// The cross-entropy method (Rubinstein 1999) on a policy that does the same whatever it sees: each
/// head's mean action and standard deviation become those of its steps in the batch's best
/// episodes. Has no gradient, no critic and no normaliser: what is left of a run when PPO is taken
/// out of it. `custom.settings` is the number of best episodes.
std::shared_ptr<const algorithm::AlgorithmFactory> MakeCrossEntropyFactory();

}  // namespace metronome::test
