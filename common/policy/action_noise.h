#pragma once

#include <array>
#include <cstdint>

#include "common/messages/episode.h"
#include "common/schema/config.pb.h"

namespace metronome::policy {

/// The standard normal numbers that make the actions of one training episode: of each component of
/// the action a first-order autoregressive sequence, n_0 = e_0 and
///   n_t = rho n_(t-1) + sqrt(1 - rho^2) e_t,   rho = policy.noise_correlation,
/// of independent e_t. Each n_t alone is standard normal, so log-probabilities stay those of the
/// Gaussian policy at each step; correlated steps carry the hand further before the policy calls it
/// back. Source: Hollenstein et al., "Colored Noise in PPO", arXiv:2312.11091, with this noise in
/// place of 1/f noise. A pure function of (run seed, episode number, t). Not thread-safe.
class ActionNoise {
 public:
  /// The first action_size of them count.
  using Numbers = std::array<float, kMaxActionSize>;

  /// @param config  resolved. @param number  of the training episode.
  ActionNoise(const RunConfig& config, std::uint64_t number);

  /// n_t, t >= 0. Cheap for t that grow; an earlier t than the last begins at 0 again.
  Numbers At(std::int32_t t);

 private:
  using Doubles = std::array<double, kMaxActionSize>;

  [[nodiscard]] Doubles Independent(std::int32_t t) const;

  std::int32_t size_;  // numbers an action
  std::uint64_t seed_;
  std::uint64_t number_;
  double correlation_;
  std::int32_t t_ = -1;  // state_ is n of this step; -1: none
  Doubles state_{};
};

}  // namespace metronome::policy
