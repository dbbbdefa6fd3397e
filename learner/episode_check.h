#pragma once

#include <optional>
#include <string>

#include "common/config.pb.h"
#include "common/episode.h"
#include "common/messages.h"

namespace metronome {

/// Why an episode cannot be right, or std::nullopt if it can: lengths, version, finiteness, flags,
/// heads against the schedule, and - step by step with the function that actors use - action and
/// log-probability, which must have equal bits. Stateless and thread-safe.
/// @param snapshot  the version that the episode names.
std::optional<std::string> CheckEpisode(const Episode& episode, const PolicySnapshot& snapshot,
                                        const RunConfig& config);

}  // namespace metronome
