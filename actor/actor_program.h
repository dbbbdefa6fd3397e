#pragma once

#include "actor/environment/registry.h"

namespace metronome::actor {

/// metronome-actor with the environments of `registry`: all that main does. @return exit status.
int RunActorProgram(int argc, char** argv, const environment::EnvironmentRegistry& registry);

}  // namespace metronome::actor
