#pragma once

#include <cstdint>
#include <vector>

#include "common/checkpoint/train_state.h"
#include "common/messages/messages.h"
#include "common/policy/running_statistics.h"
#include "common/schema/config.pb.h"
#include "learner/sac/gradient_step.h"

namespace metronome::sac {

/// Everything that an update of SAC starts from, but for the episodes of the replay.
struct SacState : checkpoint::RunCounters {
  OptimiserState optimiser;
  /// One a task, [tasks]: a dimension each number of an observation; enters snapshots from the next
  /// version on.
  std::vector<policy::RunningStatistics> observation;
  /// overlap 1: what version - 1 acted with; batch `version` was played under it.
  std::vector<float> previous_actor;
  std::vector<policy::RunningStatistics> previous_observation;  // [tasks]
  bool operator==(const SacState&) const = default;
};

/// Version 0: orthogonal weights from the seed; heads of the policy near zero, of the critics zero;
/// targets as the critics.
SacState InitialSacState(const RunConfig& config);

/// The policy for actors at state.version; incarnation is left 0 for the sender to fill.
PolicySnapshot SnapshotOf(const SacState& state, const RunConfig& config);
/// The policy at state.version - 1 (overlap 1). @throws std::logic_error at version 0.
PolicySnapshot PreviousSnapshotOf(const SacState& state, const RunConfig& config);

/// AlgorithmState::format of what EncodeSacState makes; grows whenever an older build would misread
/// it.
inline constexpr std::uint32_t kSacStateFormat = 1;

/// As a checkpoint keeps it, and back. Its digest is of actor, critics, targets and
/// log-temperatures, in this order. @param config  resolved.
/// @throws UnusableState (learner/algorithm/algorithm_factory.h) for another algorithm's state, an
///         unknown format, or numbers that do not fit the configuration's networks.
checkpoint::TrainState EncodeSacState(const SacState& state, const RunConfig& config);
SacState DecodeSacState(const checkpoint::TrainState& state, const RunConfig& config);

}  // namespace metronome::sac
