#pragma once

#include <optional>
#include <string>

#include "common/config.pb.h"
#include "common/episode.h"
#include "common/policy.h"

namespace metronome {

/// Why an episode cannot be right, or std::nullopt if it can: lengths, version, finiteness, flags,
/// heads against the schedule of the run and of the episode's number, and - step by step with the
/// function that actors use - action and log-probability, which must have equal bits.
/// @param policy  of the version that the episode should have been played under; its scratch space
///                is used. One thread at a time.
std::optional<std::string> CheckEpisode(const Episode& episode, Policy& policy,
                                        const RunConfig& config);

}  // namespace metronome
