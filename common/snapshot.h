#pragma once

#include "common/config.pb.h"
#include "common/messages.h"
#include "common/train_state.h"

namespace metronome {

/// What actors act with at state.version; incarnation is left 0 for the sender to fill.
PolicySnapshot SnapshotOf(const TrainState& state, const RunConfig& config);
/// What they acted with at state.version - 1 (overlap 1). @throws std::logic_error at version 0.
PolicySnapshot PreviousSnapshotOf(const TrainState& state, const RunConfig& config);

}  // namespace metronome
