#pragma once

#include <cstddef>

#include "common/policy/network.h"
#include "common/schema/config.pb.h"

namespace metronome::sac {

/// Twin critics, against overestimation (Fujimoto et al., arXiv:1802.09477).
inline constexpr std::size_t kCritics = 2;

/// The networks of a run. A critic's input is the policy's, the time where policy.critic_time asks
/// for it, then the action; each head's outputs are the logits of the bins of a value.
struct SacNetworks {
  /// @param config  resolved.
  explicit SacNetworks(const RunConfig& config);

  policy::NetworkShape shape;
  policy::MlpLayout actor;
  policy::MlpLayout critic;  // of each of the two
  std::size_t bins = 0;

  [[nodiscard]] std::size_t state_inputs() const { return std::size_t(shape.critic_input()); }
  [[nodiscard]] std::size_t actions() const { return std::size_t(shape.action); }
  [[nodiscard]] std::size_t critic_inputs() const { return state_inputs() + actions(); }
};

}  // namespace metronome::sac
