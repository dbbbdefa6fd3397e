#pragma once

#include <string>

namespace metronome {

/// What two hosts must agree on bit for bit to play the same episodes, as two hex SHA-256 one after
/// the other:
/// - of the environment: 100 steps of `task` at a fixed placement under fixed pseudo-random actions
///   (observations and rewards as float32), and the elementary functions that noise, policy and
///   rewards use. Checkpoints of older builds hold it alone: it must not change;
/// - of the policy: decisions of a network of fixed pseudo-random weights, whose sums and tanh are
///   Eigen's.
/// A pure function of the task, the engine, the build and the processor. About 0.1 s, and the
/// scene's loading time.
/// @param assets  folder of the scene files; empty: the default.
/// @throws as metaworld::MakeEnvironment.
std::string CanonicalDigest(const std::string& task, const std::string& assets = "");

}  // namespace metronome
