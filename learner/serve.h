#pragma once

#include "learner/algorithm/algorithm_factory.h"
#include "learner/options.h"

namespace metronome::learner {

/// `metronome-learner run`: serves a run to its end over DDS, by the algorithm of `algorithms` that
/// its configuration names. Blocks; call once a process, before
/// any other thread exists. @return an ExitCode (common/process/exit_codes.h); errors are logged.
int ServeRun(const RunOptions& options, const algorithm::Algorithms& algorithms);

}  // namespace metronome::learner
