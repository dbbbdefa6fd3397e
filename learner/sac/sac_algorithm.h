#pragma once

#include <memory>

#include "learner/algorithm/algorithm_factory.h"

namespace metronome::sac {

/// Multi-head SAC (trainer.h) as an algorithm, "sac" of configurations.
std::shared_ptr<const algorithm::AlgorithmFactory> MakeSacFactory();

}  // namespace metronome::sac
