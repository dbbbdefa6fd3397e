#pragma once

#include <memory>

#include "learner/algorithm/algorithm_factory.h"

namespace metronome::ppo {

/// Multi-head PPO (trainer.h) as an algorithm, "ppo" of configurations.
std::shared_ptr<const algorithm::AlgorithmFactory> MakePpoFactory();

}  // namespace metronome::ppo
