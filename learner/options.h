#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "common/config.pb.h"
#include "common/logging.h"

/// The command line of metronome-learner.
namespace metronome {

enum class ProgressStyle { kLines, kJson, kNone };

/// `run`: everything checked, nothing started.
struct RunOptions {
  std::string run;     // its name: folder and DDS partition
  std::string folder;  // RUNS_DIR/NAME; may not exist yet
  bool resume = false;
  RunConfig config;  // resolved and valid; with `resume` the run's own, runtime as asked for
  std::vector<std::string> warnings;  // to be logged
  ProgressStyle progress = ProgressStyle::kLines;
  LogOptions log;
};

/// `inspect`.
struct InspectOptions {
  std::string checkpoint;
  bool json = false;
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

using LearnerCommand = std::variant<RunOptions, InspectOptions, PrintConfigOptions, StatusOptions>;

/// Reads configuration files and, with --resume, the run's own, or its checkpoint's where that file
/// is missing or torn. Prints help and errors itself.
/// @return the command, or the exit status to end with: 0 after help, 2 after a usage error, among
///         them a run that exists (without --resume) or does not (with it), and a difference that
///         forbids resuming.
std::variant<int, LearnerCommand> ParseLearnerCommand(int argc, const char* const* argv);

/// RUN_FOLDER/config.textproto, the resolved configuration of a run.
std::string ConfigPathOf(const std::string& run_folder);

}  // namespace metronome
