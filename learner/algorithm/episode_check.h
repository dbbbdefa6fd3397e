#pragma once

#include <optional>
#include <string>

#include "common/messages/episode.h"
#include "common/policy/policy.h"
#include "common/schema/config.pb.h"

namespace metronome::algorithm {

/// Magnitudes beyond which an environment's numbers are taken for a fault: Meta-World's rewards are
/// at most 10 (before environment.success_reward, which the learner adds itself), its observations
/// metres and quaternions.
inline constexpr float kLargestReward = 1000;
inline constexpr float kLargestObservation = 1e6F;

/// Why an episode cannot be right, or std::nullopt if it can: version, the sizes and the end that
/// the environment's specification allows, finiteness, range, heads against the schedule of the run
/// and of the episode's number, and - step by step with the function that actors use - action and
/// log-probability, which must have equal bits.
/// @param key     decides which steps are recomputed where collection.check_share is below 1; no
///                actor may know it, so not the run's seed.
/// @param policy  of the version that the episode should have been played under; its scratch space
///                is used. One thread at a time.
std::optional<std::string> CheckEpisode(const Episode& episode, policy::Policy& policy,
                                        const RunConfig& config, std::uint64_t key);

}  // namespace metronome::algorithm
