#pragma once

#include <vector>

#include "actor/environment/registry.h"

namespace metronome::metaworld::tasks {

/// The table of tasks as environments: metaworld/NAME, NAME, NAME-v2 and NAME-v3.
std::vector<environment::EnvironmentEntry> Environments();

/// The official benchmarks of several tasks: mt10, mt50, ml10-train, ml10-test, ml45-train,
/// ml45-test.
std::vector<environment::TaskGroup> Groups();

/// @throws std::runtime_error if this machine has no scene files (says to run deploy/setup).
void RequireScenes();

}  // namespace metronome::metaworld::tasks
