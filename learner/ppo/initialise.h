#pragma once

#include <cstdint>
#include <vector>

#include "common/policy/network.h"

namespace metronome::ppo {

/// Initial parameters, actor then critic: orthogonal weights (Saxe et al., arXiv:1312.6120; gain
/// sqrt 2 in hidden layers, 0.01 for each action head, 1 for each value head), zero biases, and
/// `log_std` everywhere. A pure function of its arguments.
std::vector<float> InitialParameters(const policy::NetworkShape& shape, double log_std,
                                     std::uint64_t seed);

}  // namespace metronome::ppo
