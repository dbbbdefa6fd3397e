#pragma once

#include <stdexcept>

#include "common/checkpoint.h"
#include "learner/options.h"

namespace metronome {

/// The run cannot be served as asked, and starting again does not help.
class CannotStart : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What a learner begins with.
struct RunStart {
  Checkpoint checkpoint;  // of version 0 where there was none
  bool resumed = false;   // the checkpoint is on disk
};

/// Version 0 of a new run; with --resume the newest checkpoint that is whole (damaged ones are put
/// aside, with a warning), or version 0 if the run never had one. Call with the run's folder
/// locked.
/// @throws CannotStart, CheckpointError, ConfigError, std::system_error naming the file and, where
///         there is one, the way out.
RunStart StartOf(const RunOptions& options);

}  // namespace metronome
