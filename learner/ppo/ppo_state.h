#pragma once

#include <cstdint>
#include <vector>

#include "common/checkpoint/train_state.h"
#include "common/messages/episode.h"
#include "common/messages/messages.h"
#include "common/policy/running_statistics.h"
#include "common/schema/config.pb.h"
#include "learner/network/shared_heads.h"

namespace metronome::ppo {

/// Everything that an update of PPO starts from.
struct PpoState : checkpoint::RunCounters {
  std::vector<float> parameters;  // actor then critic, see common/policy/network.h
  std::vector<float> adam_m;      // same length
  std::vector<float> adam_v;      // same length
  std::uint64_t adam_steps = 0;
  network::SharedHeads::Moments shared;  // empty without ppo.shared_heads
  /// One a task, [tasks]: a dimension each number of an observation; enters snapshots from the next
  /// version on.
  std::vector<policy::RunningStatistics> observation;
  /// One a task, [tasks], a dimension each part of the reward: discounted return, the reward's
  /// scale.
  std::vector<policy::RunningStatistics> reward_return;
  /// The latest batches' episodes, in number order: ppo.earlier_batches of them, or all there were.
  std::vector<Episode> earlier;
  /// overlap 1: what version - 1 acted with; batch `version` was played under it.
  std::vector<float> previous_actor;
  std::vector<policy::RunningStatistics> previous_observation;  // [tasks]
  bool operator==(const PpoState&) const = default;
};

/// The policy for actors at state.version; incarnation is left 0 for the sender to fill.
PolicySnapshot SnapshotOf(const PpoState& state, const RunConfig& config);
/// The policy at state.version - 1 (overlap 1). @throws std::logic_error at version 0.
PolicySnapshot PreviousSnapshotOf(const PpoState& state, const RunConfig& config);

/// AlgorithmState::format of what EncodePpoState makes; grows whenever an older build would misread
/// it. 1: without shared heads. 2: without earlier batches, and one value of all rewards.
inline constexpr std::uint32_t kPpoStateFormat = 3;

/// As a checkpoint keeps it, and back. @param config  resolved.
/// @throws UnusableState (learner/algorithm/algorithm_factory.h) for another algorithm's state, an
///         unknown format, or numbers that do not fit the configuration's network.
checkpoint::TrainState EncodePpoState(const PpoState& state, const RunConfig& config);
PpoState DecodePpoState(const checkpoint::TrainState& state, const RunConfig& config);

}  // namespace metronome::ppo
