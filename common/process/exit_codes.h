#pragma once

namespace metronome::process {

/// How metronome-learner and metronome-actor end. Scripts depend on the numbers.
enum ExitCode : int {
  kExitFinished = 0,
  kExitFailure = 1,      // anything else: the log says what
  kExitUsage = 2,        // nothing was started, and trying again does not help
  kExitNoLearner = 3,    // actor, status: no learner of that run is heard
  kExitRival = 4,        // another learner has the run
  kExitNonFinite = 5,    // an update was not finite; the last good checkpoint is kept
  kExitSignalBase = 128  // + signal: 130 after SIGINT, 143 after SIGTERM, with a checkpoint
};

}  // namespace metronome::process
