#include "learner/options.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <system_error>
#include <vector>

#include "common/checkpoint/checkpoint.h"
#include "common/config/config.h"
#include "common/kernels/isa_option.h"
#include "common/process/build_info.h"
#include "common/process/files.h"
#include "common/process/logging.h"
#include "common/text/cli_number.h"
#include "common/text/cli_parse.h"
#include "common/text/near_miss.h"
#include "learner/record/run_folder.h"
#include "learner/run/initial_weights.h"

namespace metronome::learner {
namespace {

namespace fs = std::filesystem;

/// A dedicated option: a short name for one configuration field.
struct FieldOption {
  const char* name;
  const char* path;
  const char* value_name;
  const char* help;
};

constexpr FieldOption kFieldOptions[] = {
    {"--task", "environment.task", "T",
     "The task to learn; `metronome-actor environment` lists all"},
    {"--method", "policy.method", "M",
     "multihead (k heads, time picks one), single (one head), single-time (one head that sees the "
     "time); ppo and ppo-time are other names of the latter two"},
    {"--heads", "policy.heads", "K",
     "Heads of multihead, at most the horizon [default: 10; the other methods have 1]"},
    {"--steps", "total_steps", "S",
     "Environment steps in all, rounded up to whole updates; with SAC 2000000 if not given"},
    {"--seed", "seed", "N", "Key of every random stream"},
    {"--from", "policy.initial_weights", "CHECKPOINT",
     "Begin a new run with this checkpoint's weights and observation statistics: of the same "
     "method, heads and sizes [default: none]"},
    {"--horizon", "environment.horizon", "T",
     "Steps after which an episode ends at the latest [default: the environment's longest "
     "episode]"},
    {"--placements", "environment.placements", "P",
     "Of object and goal: random (each episode its own), fixed (one, by seed), mt1 (the official "
     "50), benchmark (of several tasks, those of the official benchmark)"},
    {"--goal", "environment.goal_visible", "G",
     "hidden or visible: whether observations show the goal [default: visible]"},
    {"--reward", "environment.reward", "R",
     "What to learn from: official (the environment's), or success (and 25 more after each step "
     "with "
     "success); reports and evaluations have the official one"},
    {"--domain", "runtime.domain", "N", "DDS domain, 0 to 232"},
    {"--transport", "runtime.transport", "X", "udp, shm (shared memory) or tcp"},
    {"--network", "runtime.network", "W",
     "Who can join: loopback (this machine), lan, or the peers' addresses separated by commas; "
     "with "
     "tcp this machine's address HOST[:PORT], as actors are to connect to it"},
    {"--discovery-server", "runtime.discovery_server", "HOST[:PORT],...",
     "Fast DDS Discovery Servers that introduce peers in place of multicast; with --network lan"},
    {"--security", "runtime.security", "DIR",
     "The learner's identity, made by deploy/security: only the run's own identities take part, "
     "all "
     "is encrypted [default: none]"},
    {"--threads", "runtime.learner_threads", "N", "Threads of an update; 0: all cores"},
    {"--audit", "runtime.audit_share", "X",
     "Share of episodes, 0 to 1, that two actors play and that must agree bit for bit"},
    {"--metrics", "runtime.metrics", "[H:]PORT",
     "Show the learner's status to Prometheus at http://H:PORT/metrics; H 127.0.0.1 unless given, "
     "port 0 any free one [default: off]"},
    {"--checkpoint-every", "runtime.checkpoint_every", "N", "Updates between checkpoints"},
};

/// The values of the options that `run` and `config` share.
struct ConfigArguments {
  std::string algorithm;
  std::map<std::string, std::string> fields;  // option name -> text
  std::vector<std::string> settings;          // of --set
  std::vector<std::string> files;             // of --config
};

struct RunArguments {
  std::string run;
  std::string runs_dir = "runs";
  bool resume = false;
  bool new_total = false;
  std::string progress = "lines";
  process::LogOptions log;
};

std::string DefaultText(const std::string& wanted) {
  std::string text;
  config::VisitFields(config::Resolve(RunConfig()),
                      [&](const std::string& path, const auto& owner, const auto& field) {
                        if (path == wanted) text = config::FieldText(owner, field);
                      });
  return text;
}

std::string HelpOf(const FieldOption& option) {
  std::string help = option.help;
  if (help.ends_with("]") || option.path == std::string("environment.task")) return help;
  return help + " [default: " + DefaultText(option.path) + "]";
}

void AddConfigOptions(CLI::App& command, ConfigArguments& arguments) {
  command
      .add_option("--algorithm", arguments.algorithm,
                  "ppo, sac, or another that the learner knows [default: ppo]")
      ->type_name("A");
  for (const FieldOption& option : kFieldOptions) {
    command.add_option(option.name, arguments.fields[option.name], HelpOf(option))
        ->type_name(option.value_name);
  }
  command
      .add_option(
          "--config", arguments.files,
          "Configuration file in Protobuf text format (fields: common/schema/config.proto); may be "
          "repeated. A later file overrides an earlier one field by field, a list as a whole")
      ->type_name("FILE")
      ->allow_extra_args(false);
  command
      .add_option(
          "--set", arguments.settings,
          "One configuration field, e.g. ppo.learning_rate=3e-4 or policy.hidden=64,64; may "
          "be repeated. Overrides --config; the options above override both")
      ->type_name("A.B=C")
      ->allow_extra_args(false);
}

void AddRunOptions(CLI::App& command, RunArguments& arguments) {
  command.add_option("--run", arguments.run, "Name of the run: its folder, and what actors join")
      ->type_name("NAME");
  command
      .add_option("--runs,--runs-dir", arguments.runs_dir,
                  "Folder of all runs [default: " + arguments.runs_dir + "]")
      ->type_name("DIR");
  command.add_flag("--resume", arguments.resume,
                   "Go on from the run's newest checkpoint, with its own configuration");
  command.add_flag("--new-total", arguments.new_total,
                   "With --resume: let --steps differ (the learning rate depends on it)");
  command
      .add_option("--progress", arguments.progress,
                  "On standard output: lines, json or none [default: " + arguments.progress + "]")
      ->type_name("X");
  command
      .add_option("--log-level", arguments.log.level,
                  "On standard error: " + text::JoinNames(process::LogLevels()) +
                      " [default: " + arguments.log.level + "]")
      ->type_name("X");
  command
      .add_option(
          "--log-format", arguments.log.format,
          "Of the log: text, or json: one object a line [default: " + arguments.log.format + "]")
      ->type_name("X");
}

void AddStatusOptions(CLI::App& command, StatusOptions& options) {
  command.add_option("RUN,--run", options.run, "Name of the run")->type_name("NAME");
  command.add_option("--domain", options.domain, "DDS domain, 0 to 232 [default: 0]")
      ->type_name("N")
      ->transform(text::Number<std::uint32_t>(0, 232));
  command.add_option("--transport", options.transport, "udp, shm or tcp [default: udp]")
      ->type_name("X");
  command
      .add_option("--network", options.network,
                  "Where the learner is: loopback (this machine), lan, or addresses separated by "
                  "commas [default: loopback]")
      ->type_name("W");
  command
      .add_option("--discovery-server", options.discovery_server,
                  "Discovery Servers, as the learner has them")
      ->type_name("HOST[:PORT],...");
  command
      .add_option("--security", options.security,
                  "An observer's identity, for a run that has --security [default: none]")
      ->type_name("DIR");
  command.add_flag("--json", options.json, "As one JSON object a line");
  command.add_flag("--follow", options.follow, "Again each second, until the run ends or Ctrl-C");
  command
      .add_option("--wait", options.wait_seconds, "Seconds to look for the learner [default: 10]")
      ->type_name("S")
      ->transform(text::Number<double>(0, 86400));
}

/// --goal speaks in words, its field is a truth value.
std::string FieldValue(const FieldOption& option, const std::string& text) {
  if (option.name != std::string("--goal")) return text;
  if (text == "visible") return "true";
  if (text == "hidden") return "false";
  throw config::ConfigError("--goal: " + text::UnknownName("value", text, {"visible", "hidden"}));
}

RunConfig BuildConfig(config::ConfigDraft draft, const CLI::App& command,
                      const ConfigArguments& arguments, const config::SpecSource& specs) {
  for (const std::string& file : arguments.files) draft.ReadFile(file);
  if (!arguments.algorithm.empty()) draft.ChooseAlgorithm(arguments.algorithm, "--algorithm");
  for (const std::string& setting : arguments.settings) draft.SetFromArgument(setting);
  for (const FieldOption& option : kFieldOptions) {
    if (command.get_option(option.name)->count() == 0) continue;
    draft.Set(option.path, FieldValue(option, arguments.fields.at(option.name)), option.name);
  }
  RunConfig config = draft.Finish(specs);
  const std::string& method = arguments.fields.at("--method");
  if (!config.has_ppo() && (method == "ppo" || method == "ppo-time")) {
    throw config::ConfigError("--method " + method + ": the algorithm is " +
                              config::AlgorithmName(config) + "; its methods are multihead, " +
                              "single and single-time");
  }
  std::string& weights = *config.mutable_policy()->mutable_initial_weights();
  if (!weights.empty()) weights = fs::absolute(weights).lexically_normal().string();
  return config;
}

record::ProgressStyle ProgressOf(const std::string& word) {
  const std::map<std::string, record::ProgressStyle> styles = {
      {"lines", record::ProgressStyle::kLines},
      {"json", record::ProgressStyle::kJson},
      {"none", record::ProgressStyle::kNone}};
  const auto found = styles.find(word);
  if (found != styles.end()) return found->second;
  throw config::ConfigError("--progress: " +
                            text::UnknownName("value", word, {"lines", "json", "none"}));
}

void RequireKnown(const std::string& option, const std::string& word,
                  const std::vector<std::string>& words) {
  if (std::find(words.begin(), words.end(), word) != words.end()) return;
  throw config::ConfigError(option + ": " + text::UnknownName("value", word, words));
}

/// The configuration that the run's file holds; none if it is missing or ends too early.
/// @throws ConfigError.
std::optional<RunConfig> ConfigOfFile(const std::string& path) {
  if (!fs::exists(path)) return std::nullopt;
  std::string text;
  try {
    text = process::ReadFile(path);
  } catch (const std::system_error& error) {
    throw config::ConfigError("cannot read " + path + ": " + error.code().message());
  }
  // PrintConfig writes the total last.
  const bool whole = text.ends_with('\n') && text.find("\ntotal_steps:") != std::string::npos;
  if (!whole) return std::nullopt;
  try {
    return config::ParseConfigText(text, path).config;
  } catch (const config::ConfigError& error) {
    throw config::ConfigError(
        std::string(error.what()) +
        " (without the file, --resume takes the newest checkpoint's configuration)");
  }
}

/// The run's own configuration: its file's, or its newest checkpoint's. @throws ConfigError.
RunConfig OwnConfig(const std::string& folder, const config::SpecSource& specs,
                    std::vector<std::string>& warnings) {
  const std::string path = record::ConfigPathOf(folder);
  if (auto config = ConfigOfFile(path)) return *config;
  const std::string damage = path + (fs::exists(path) ? " is not whole" : " is missing");
  try {
    if (const auto found = checkpoint::FindNewestCheckpoint(folder + "/checkpoints", specs)) {
      warnings.push_back(damage + ": it is made anew from " + found->path);
      return found->checkpoint.config;
    }
  } catch (const checkpoint::CheckpointError& error) {
    throw config::ConfigError(damage + ", and " + error.what());
  }
  if (fs::exists(path) || fs::exists(folder + "/checkpoints")) {
    throw config::ConfigError(damage +
                              ", and the run has no checkpoint: begin anew under another --run");
  }
  throw config::ConfigError("no run to resume: there is no " + path +
                            " (--runs names the folder of all runs)");
}

RunConfig ResumedConfig(const RunArguments& run, const CLI::App& command,
                        const ConfigArguments& arguments, RunOptions& options) {
  RunConfig old_config = OwnConfig(options.folder, options.specs, options.warnings);
  config::CompleteSpec(old_config, options.specs);
  old_config = config::Resolve(std::move(old_config));
  RunConfig config =
      BuildConfig(config::ConfigDraft(old_config), command, arguments, options.specs);
  const auto differences = config::CompareForResume(old_config, config, run.new_total);
  if (differences.empty()) return config;
  std::string message = "cannot resume run " + run.run + " with another configuration:";
  for (const auto& difference : differences) message += "\n  " + difference;
  throw config::ConfigError(message);
}

RunOptions BuildRun(const RunArguments& run, const CLI::App& command,
                    const ConfigArguments& arguments, const config::SpecSource& specs) {
  if (run.run.empty()) throw config::ConfigError("--run NAME is needed: it names the run's folder");
  config::CheckRunName(run.run);
  if (run.new_total && !run.resume) throw config::ConfigError("--new-total is for --resume only");
  RunOptions options;
  options.run = run.run;
  options.specs = specs;
  options.folder = (fs::path(run.runs_dir) / run.run).string();
  options.resume = run.resume;
  options.progress = ProgressOf(run.progress);
  options.log = run.log;
  RequireKnown("--log-level", run.log.level, process::LogLevels());
  RequireKnown("--log-format", run.log.format, process::LogFormats());
  if (run.resume) {
    options.config = ResumedConfig(run, command, arguments, options);
    return options;
  }
  options.config = BuildConfig(config::ConfigDraft(), command, arguments, specs);
  if (fs::exists(record::ConfigPathOf(options.folder)) ||
      fs::exists(fs::path(options.folder) / "checkpoints")) {
    throw config::ConfigError("run " + run.run + " exists (" + options.folder +
                              "): --resume goes on with it; choose another --run for a new one");
  }
  if (!options.config.policy().initial_weights().empty()) {
    run::LoadInitialWeights(options.config, specs);
  }
  return options;
}

}  // namespace

std::variant<int, LearnerCommand> ParseLearnerCommand(int argc, const char* const* argv,
                                                      const config::SpecSource& specs) {
  CLI::App app("Learns a task from the episodes of actors (metronome-actor run --run NAME).",
               "metronome-learner");
  app.set_version_flag("--version", process::BuildIdentity() + ", " + process::EngineName());
  ConfigArguments arguments, print_arguments;
  RunArguments run;
  InspectOptions inspect;
  ExportOptions exported;
  StatusOptions status;

  CLI::App* run_command = app.add_subcommand("run", "Start a run, or go on with one (--resume)");
  AddRunOptions(*run_command, run);
  kernels::AddIsaOption(*run_command);
  AddConfigOptions(*run_command, arguments);
  CLI::App* inspect_command = app.add_subcommand("inspect", "Show what a checkpoint holds");
  inspect_command->add_option("CHECKPOINT", inspect.checkpoint, "The file")->type_name("");
  inspect_command->add_flag("--json", inspect.json, "As one JSON object");
  CLI::App* export_command = app.add_subcommand(
      "export", "Write a checkpoint's policy by itself: to evaluate and draw, not to go on from");
  export_command->add_option("CHECKPOINT", exported.checkpoint, "The file")->type_name("");
  export_command->add_option("--out", exported.out, "The file to write")->type_name("FILE");
  CLI::App* config_command =
      app.add_subcommand("config", "Print the whole configuration that run would use");
  AddConfigOptions(*config_command, print_arguments);

  CLI::App* status_command =
      app.add_subcommand("status", "Show a running run, from any terminal or machine");
  AddStatusOptions(*status_command, status);

  if (const auto code = text::ParseCommandLine(app, argc, argv)) return *code;
  const CLI::App& given = *app.get_subcommands().front();
  try {
    if (&given == run_command) return BuildRun(run, given, arguments, specs);
    if (&given == config_command) {
      return PrintConfigOptions{BuildConfig(config::ConfigDraft(), given, print_arguments, specs)};
    }
    if (&given == status_command) {
      if (status.run.empty())
        throw config::ConfigError("name the run to show: metronome-learner status NAME");
      config::CheckRunName(status.run);
      return status;
    }
    if (&given == export_command) {
      if (exported.checkpoint.empty())
        throw config::ConfigError("name the CHECKPOINT file whose policy to write");
      if (exported.out.empty()) throw config::ConfigError("--out FILE is needed: where to write");
      return exported;
    }
    if (inspect.checkpoint.empty())
      throw config::ConfigError("name the CHECKPOINT file to inspect");
    return inspect;
  } catch (const fs::filesystem_error& error) {
    return text::UsageError(app.get_name() + " " + given.get_name(),
                            "cannot look into " + error.path1().string() + ": " +
                                error.code().message() + " (--runs names another folder of runs)");
  } catch (const config::ConfigError& error) {
    return text::UsageError(app.get_name() + " " + given.get_name(), error.what());
  }
}

}  // namespace metronome::learner
