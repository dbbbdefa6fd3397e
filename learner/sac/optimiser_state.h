#pragma once

#include <cstdint>
#include <vector>

#include "learner/network/shared_heads.h"

namespace metronome::sac {

/// What gradient steps change.
struct OptimiserState {
  struct Moments {  // of Adam
    std::vector<float> m;
    std::vector<float> v;
    bool operator==(const Moments&) const = default;
  };

  using Shared = network::SharedHeads::Moments;

  std::vector<float> actor;
  std::vector<float> critics;          // the first, then the second
  std::vector<float> targets;          // as critics
  std::vector<float> log_temperature;  // [heads]
  Moments of_actor;
  Moments of_critics;
  Moments of_log_temperature;
  Shared of_actor_heads;  // empty without sac.shared_heads, as the next
  Shared of_critic_heads;
  std::uint64_t gradient_steps = 0;  // made since the run began
  bool operator==(const OptimiserState&) const = default;
};

}  // namespace metronome::sac
