#pragma once

#include "actor/environment/registry.h"

namespace metronome {

/// metronome-actor with the environments of `registry`: all that main does. @return exit status.
int RunActorProgram(int argc, char** argv, const EnvironmentRegistry& registry);

}  // namespace metronome
