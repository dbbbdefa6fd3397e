#pragma once

#include <string>

namespace metronome {

/// Hex SHA-256 of what two hosts must agree on bit for bit to play the same episodes: 100 steps of
/// `task` at a fixed placement under fixed pseudo-random actions (observations and rewards as
/// float32), and the elementary functions that noise, policy and rewards use. A pure function of
/// the task, the engine, the build and the processor. About 0.1 s, and the scene's loading time.
/// @param assets  folder of the scene files; empty: the default.
/// @throws as metaworld::MakeEnvironment.
std::string CanonicalDigest(const std::string& task, const std::string& assets = "");

}  // namespace metronome
