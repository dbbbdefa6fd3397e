#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/checkpoint/checkpoint.h"
#include "common/config/environment_spec.h"
#include "common/schema/config.pb.h"
#include "learner/algorithm/algorithm_factory.h"

namespace metronome::run {

/// Which run, and how it is to be.
struct RunRequest {
  std::string run;     // its name: folder and DDS partition
  std::string folder;  // RUNS_DIR/NAME; may not exist yet
  bool resume = false;
  RunConfig config;  // resolved and valid; with `resume` the run's own, runtime as asked for
  config::SpecSource specs;  // asked what the environments of older checkpoints are like
};

/// The run cannot be served as asked, and starting again does not help.
class CannotStart : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The beginning of a learner's work.
struct RunStart {
  checkpoint::Checkpoint checkpoint;  // of version 0 where there was none
  bool resumed = false;               // the checkpoint is on disk
  std::string path;                   // there
  std::vector<Episode> replay;        // the checkpoint's, of an algorithm that has one
};

/// Version 0 of a new run; with --resume the newest checkpoint that is whole (damaged ones are put
/// aside, with a warning), or version 0 if the run never had one. Call with the run's folder
/// locked.
/// @param factory  of the run's algorithm.
/// @throws CannotStart, CheckpointError, ConfigError, std::system_error naming the file and, where
///         there is one, the way out.
RunStart StartOf(const RunRequest& request, const algorithm::AlgorithmFactory& factory);

/// The algorithm at the start's state, with its replay, which leaves `start`.
/// @param resources  all but the replay. @throws CannotStart naming the file if it cannot go on.
std::unique_ptr<algorithm::Algorithm> AlgorithmOf(RunStart& start,
                                                  const algorithm::AlgorithmFactory& factory,
                                                  algorithm::AlgorithmResources resources);

}  // namespace metronome::run
