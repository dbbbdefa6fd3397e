#pragma once

#include "learner/options.h"

namespace metronome::learner {

/// `status`: shows the newest learner of a run, over DDS alone. @return an ExitCode;
/// process::kExitNoLearner if none of that run is heard in time.
int WatchRun(const StatusOptions& options);

}  // namespace metronome::learner
