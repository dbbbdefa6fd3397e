#pragma once

#include <optional>
#include <string>

#include "common/messages/messages.h"
#include "common/policy/train_state.h"
#include "common/schema/config.pb.h"

namespace metronome {

/// What actors act with at state.version; incarnation is left 0 for the sender to fill.
PolicySnapshot SnapshotOf(const TrainState& state, const RunConfig& config);
/// What they acted with at state.version - 1 (overlap 1). @throws std::logic_error at version 0.
PolicySnapshot PreviousSnapshotOf(const TrainState& state, const RunConfig& config);

/// What keeps actors from acting with a snapshot, for a message: another shape than the resolved
/// configuration's, or numbers so large or small that float32 may give an action or log-probability
/// that is not finite, though they are. std::nullopt if nothing does, whatever is observed.
std::optional<std::string> SnapshotDefect(const PolicySnapshot& snapshot, const RunConfig& config);

}  // namespace metronome
