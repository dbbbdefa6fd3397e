#pragma once

#include "learner/algorithm/algorithm_factory.h"

namespace metronome::learner {

/// The whole of metronome-learner: reads the command line and does what it says, with the
/// algorithms that the program was built with. Call once a process, before any other thread exists.
/// @return the exit status.
int LearnerProgram(int argc, char** argv, const algorithm::Algorithms& algorithms);

}  // namespace metronome::learner
