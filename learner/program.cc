#include "learner/program.h"

#include <cstdio>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <variant>

#include "common/checkpoint/checkpoint.h"
#include "common/config/config.h"
#include "common/policy/network.h"
#include "common/process/exit_codes.h"
#include "common/process/files.h"
#include "common/process/ignored_signals.h"
#include "learner/actor_program.h"
#include "learner/options.h"
#include "learner/record/inspect.h"
#include "learner/serve.h"
#include "learner/show_status.h"

namespace metronome::learner {
namespace {

/// Flushes the result on standard output. @throws std::runtime_error if it is lost (a full disk,
/// say).
void RequireWritten() {
  if (!std::cout.flush()) throw std::runtime_error("cannot write to standard output");
}

int Execute(const RunOptions& options, const algorithm::Algorithms& algorithms) {
  return ServeRun(options, algorithms);
}

int Execute(const StatusOptions& options, const algorithm::Algorithms& /*algorithms*/) {
  return WatchRun(options);
}

int Execute(const InspectOptions& options, const algorithm::Algorithms& /*algorithms*/) {
  try {
    const checkpoint::Checkpoint checkpoint =
        checkpoint::LoadCheckpoint(options.checkpoint, AskActorProgram());
    (options.json ? record::PrintCheckpointJson : record::PrintCheckpoint)(checkpoint, std::cout);
    RequireWritten();
    return process::kExitFinished;
  } catch (const std::exception& error) {
    std::cerr << "metronome-learner inspect: " << error.what() << "\n";
    return process::kExitFailure;
  }
}

int Execute(const ExportOptions& options, const algorithm::Algorithms& /*algorithms*/) {
  try {
    const checkpoint::Checkpoint checkpoint =
        checkpoint::LoadCheckpoint(options.checkpoint, AskActorProgram());
    process::WriteFileAtomically(options.out,
                                 checkpoint::EncodeCheckpoint(checkpoint::PolicyAlone(checkpoint)));
    return process::kExitFinished;
  } catch (const std::exception& error) {
    std::cerr << "metronome-learner export: " << error.what() << "\n";
    return process::kExitFailure;
  }
}

// The counts are a comment: the output is a configuration file.
int Execute(const PrintConfigOptions& options, const algorithm::Algorithms& /*algorithms*/) {
  const policy::NetworkShape shape = policy::ShapeOf(options.config);
  std::cout << "# parameters: " << policy::ParameterCount(shape) << " (actor "
            << policy::ActorLayout(shape).size << ", critic " << policy::CriticLayout(shape).size
            << ")\n"
            << config::PrintConfig(options.config);
  RequireWritten();
  return process::kExitFinished;
}

int Execute(int argc, char** argv, const algorithm::Algorithms& algorithms) {
  const auto parsed = ParseLearnerCommand(argc, argv, AskActorProgram());
  if (const int* status = std::get_if<int>(&parsed)) return *status;
  return std::visit([&](const auto& command) { return Execute(command, algorithms); },
                    std::get<LearnerCommand>(parsed));
}

}  // namespace

int LearnerProgram(int argc, char** argv, const algorithm::Algorithms& algorithms) {
  process::IgnoreFileSizeLimit();
  try {
    return Execute(argc, argv, algorithms);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "metronome-learner: %s\n", error.what());
    return process::kExitFailure;
  }
}

}  // namespace metronome::learner
