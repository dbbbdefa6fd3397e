#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "common/process/logging.h"
#include "common/schema/config.pb.h"
#include "learner/record/progress_printer.h"
#include "learner/run/run_start.h"

/// The command line of metronome-learner.
namespace metronome::learner {

/// `run`: everything checked, nothing started.
struct RunOptions : run::RunRequest {
  std::vector<std::string> warnings;  // to be logged
  record::ProgressStyle progress = record::ProgressStyle::kLines;
  process::LogOptions log;
};

/// `inspect`.
struct InspectOptions {
  std::string checkpoint;
  bool json = false;
};

/// `export`: the policy of a checkpoint, by itself.
struct ExportOptions {
  std::string checkpoint;
  std::string out;
};

/// `config`: print the configuration that `run` would use.
struct PrintConfigOptions {
  RunConfig config;
};

/// `status`: show a running run from anywhere.
struct StatusOptions {
  std::string run;
  std::uint32_t domain = 0;
  std::string transport = "udp";
  std::string network = "loopback";
  std::string discovery_server;
  std::string security;  // folder of an identity; empty: none
  bool json = false;
  bool follow = false;       // each second, until the run ends
  double wait_seconds = 10;  // for a learner
};

using LearnerCommand =
    std::variant<RunOptions, InspectOptions, ExportOptions, PrintConfigOptions, StatusOptions>;

/// @param specs  says what environments are like; handed on in RunOptions.
/// Reads configuration files and, with --resume, the run's own, or its checkpoint's where that file
/// is missing or torn. Prints help and errors itself.
/// @return the command, or the exit status to end with: 0 after help, 2 after a usage error, among
///         them a run that exists (without --resume) or does not (with it), and a difference that
///         forbids resuming.
std::variant<int, LearnerCommand> ParseLearnerCommand(int argc, const char* const* argv,
                                                      const config::SpecSource& specs);

}  // namespace metronome::learner
