#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/messages/messages.h"
#include "common/policy/running_statistics.h"
#include "common/schema/config.pb.h"

namespace metronome::policy {

/// The policy for actors at `version`; incarnation is left 0 for the sender to fill.
/// @param actor        the policy's parameters, ActorLayout(ShapeOf(config)).size floats.
/// @param observation  what observations are normalised by, one a task; those without a count, and
///                     all where there are none: not at all.
/// @param config       resolved.
PolicySnapshot MakeSnapshot(std::uint64_t version, const float* actor,
                            const std::vector<RunningStatistics>& observation,
                            const RunConfig& config);

/// The reason why actors cannot act with a snapshot, for a message: another shape than the resolved
/// configuration's, or numbers so large or small that float32 may give an action or log-probability
/// that is not finite, though they are. std::nullopt if nothing does, whatever is observed.
std::optional<std::string> SnapshotDefect(const PolicySnapshot& snapshot, const RunConfig& config);

}  // namespace metronome::policy
