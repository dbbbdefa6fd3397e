#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace metronome {

/// Mean and variance of a stream, merged batch by batch in double precision
/// (Chan, Golub, LeVeque 1979, parallel form). One entry per dimension.
struct RunningStatistics {
  std::vector<double> mean;
  std::vector<double> m2;  // sum of squared deviations
  double count = 0;
  bool operator==(const RunningStatistics&) const = default;
};

/// The whole state that an update starts from: update = f(state, batch). What a checkpoint holds.
struct TrainState {
  std::uint64_t version = 0;      // updates made
  std::uint64_t steps = 0;        // environment steps learnt from
  std::vector<float> parameters;  // actor then critic, see common/policy/network.h
  std::vector<float> adam_m;      // same length
  std::vector<float> adam_v;      // same length
  std::uint64_t adam_steps = 0;
  RunningStatistics observation;    // 39 dimensions, enters snapshots from the next version on
  RunningStatistics reward_return;  // 1 dimension: discounted return, the reward's scale
  /// overlap 1: what version - 1 acted with; batch `version` was played under it.
  std::vector<float> previous_actor;
  RunningStatistics previous_observation;
  /// Digest of the canonical episode that the first actor brought; others must equal it.
  std::string canonical_digest;
  std::uint64_t episodes_used = 0;  // each episode number exactly once: version * E
  bool operator==(const TrainState&) const = default;
};

}  // namespace metronome
