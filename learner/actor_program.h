#pragma once

#include "common/config/environment_spec.h"

namespace metronome::learner {

/// Environments as the program metronome-actor beside this one describes them, since the learner
/// has none itself: `metronome-actor environment NAME`, once a name. The function may be called by
/// one thread at a time.
config::SpecSource AskActorProgram();

}  // namespace metronome::learner
