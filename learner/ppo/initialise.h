#pragma once

#include <cstdint>
#include <vector>

#include "common/policy/network.h"

namespace metronome::ppo {

/// Initial parameters, actor then critic, by network::Initialiser: gain 0.01 for each action head,
/// 1 for each value head; and `log_std` everywhere. A pure function of its arguments.
std::vector<float> InitialParameters(const policy::NetworkShape& shape, double log_std,
                                     std::uint64_t seed);

}  // namespace metronome::ppo
