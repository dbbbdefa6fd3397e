#pragma once

#include <cstdint>
#include <string>

#include "common/messages/messages.h"

namespace metronome::checkpoint {

/// How far a run has come.
struct RunCounters {
  std::uint64_t version = 0;        // updates made
  std::uint64_t steps = 0;          // environment steps learnt from
  std::uint64_t episodes_used = 0;  // each episode number exactly once: version * E
  bool operator==(const RunCounters&) const = default;
};

/// The format of no state: the file holds a policy by itself.
inline constexpr std::uint32_t kPolicyAlone = 0;

/// The algorithm's own state, in an encoding that nobody else looks into.
struct AlgorithmState {
  std::string name;                     // the algorithm's, as configurations name it: "ppo"
  std::uint32_t format = kPolicyAlone;  // of `bytes`: the algorithm's own number, from 1
  std::string bytes;
  bool operator==(const AlgorithmState&) const = default;
};

/// Everything that is learnt, the policy's weights and the rest: how many float32 numbers, and
/// their WeightsSha256 (common/process/sha256.h).
struct WeightsDigest {
  std::uint64_t count = 0;
  std::string sha256;
  bool operator==(const WeightsDigest&) const = default;
};

/// The whole state that an update starts from: update = f(state, batch). What a checkpoint holds.
struct TrainState : RunCounters {
  PolicySnapshot policy;  // what actors act with at `version`; its incarnation is 0
  WeightsDigest weights;
  AlgorithmState algorithm;
  /// Digest of the canonical episode that the first actor brought; others must equal it.
  std::string canonical_digest;
  bool operator==(const TrainState&) const = default;
};

}  // namespace metronome::checkpoint
