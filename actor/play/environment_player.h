#pragma once

#include "actor/client/episode_player.h"
#include "actor/environment/registry.h"

namespace metronome::play {

/// Joins runs with the environments of `registry`, which must outlive it: players of the run's
/// environment, and the digest of its canonical episode.
client::SetUpRun SetUpWith(const environment::EnvironmentRegistry& registry);

}  // namespace metronome::play
