#pragma once

#include <memory>

#include "learner/algorithm/algorithm_factory.h"

namespace metronome {

/// Multi-head PPO (trainer.h) as an algorithm, "ppo" of configurations.
std::shared_ptr<const AlgorithmFactory> MakePpoFactory();

}  // namespace metronome
