#pragma once

#include <cstdint>

#include "common/policy/action_noise.h"
#include "common/policy/head_schedule.h"
#include "common/policy/policy.h"
#include "common/schema/config.pb.h"

namespace metronome::policy {

/// The actions of one training episode: the policy's with the episode's noise (of SAC: times the
/// episode's own factor, sac.noise_spread; log-probabilities are the policy's own all the same),
/// or, in SAC's first episodes (sac.random_episodes), uniformly random ones. A pure function of
/// (run seed, episode number, t) and of what the policy says. Not thread-safe.
class Explorer {
 public:
  /// @param config  resolved. @param number  of the training episode.
  Explorer(const RunConfig& config, std::uint64_t number);

  /// See Policy. Cheap for t that grow.
  Policy::Decision Act(Policy& policy, const HeadSchedule& schedule, const float* observation,
                       std::int32_t t);
  Policy::Decision ActAround(const Policy& policy, const HeadSchedule& schedule,
                             const Policy::Gaussian& gaussian, std::int32_t t);

 private:
  ActionNoise::Numbers Noise(std::int32_t t);
  [[nodiscard]] Policy::Action Uniform(std::int32_t t) const;

  std::int32_t size_;  // numbers an action
  std::uint64_t seed_;
  std::uint64_t number_;
  bool uniform_;
  float scale_;
  ActionNoise noise_;
};

}  // namespace metronome::policy
