#pragma once

#include "learner/options.h"

namespace metronome {

/// `metronome-learner run`: serves a run to its end over DDS. Blocks; call once a process, before
/// any other thread exists. @return an ExitCode (common/process/exit_codes.h); errors are logged.
int ServeRun(const RunOptions& options);

}  // namespace metronome
