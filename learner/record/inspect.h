#pragma once

#include <ostream>

#include "common/checkpoint/checkpoint.h"

namespace metronome::record {

/// A checkpoint's contents, for people: one `name  value` a line.
void PrintCheckpoint(const checkpoint::Checkpoint& checkpoint, std::ostream& out);

/// The same as one JSON object on one line. Stable keys: version, steps, weights_sha256; further:
/// task, algorithm, algorithm_format (of its state), method, heads, schedule, critic_heads, seed,
/// engine, build, isa, incarnation, episodes_used, parameters (their number), actor_parameters and
/// critic_parameters (of the policy, and the rest), total_steps, wall_seconds and head_std ([k],
/// mean of exp(log_std) over the action; empty where stds are of the state, as SAC's). Of a run
/// that began with another one's weights also initial_weights (the path given) and
/// initial_weights_sha256.
void PrintCheckpointJson(const checkpoint::Checkpoint& checkpoint, std::ostream& out);

}  // namespace metronome::record
