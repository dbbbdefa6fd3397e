#include "actor/options.h"

#include <CLI/CLI.hpp>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "common/config/config.h"
#include "common/dds/security/security.h"
#include "common/kernels/isa_option.h"
#include "common/process/build_info.h"
#include "common/process/logging.h"
#include "common/text/cli_number.h"
#include "common/text/cli_parse.h"
#include "common/text/near_miss.h"

namespace metronome::actor {
namespace {

constexpr const char* kProgram = "metronome-actor";

/// The options as typed, before they are judged.
struct Typed {
  JoinOptions run;
  std::string transport = "udp";
  std::string discovery_server;
  replay::TraceOptions trace;
  replay::PlacementsOptions placements;
  play::EvaluateOptions evaluate;
  render::RenderOptions render;
  DescribeOptions environment;
  TasksOptions tasks;
};

/// One of a few words; another one is answered with the near miss.
CLI::Validator OneOf(const std::string& kind, const std::vector<std::string>& words) {
  return CLI::Validator(
      [kind, words](std::string& word) {
        for (const std::string& known : words) {
          if (word == known) return std::string();
        }
        return text::UnknownName(kind, word, words);
      },
      "");
}

/// The environments that a command may name.
class TaskOption {
 public:
  explicit TaskOption(const environment::EnvironmentRegistry& registry) : registry_(registry) {}

  /// @param several  a list or a group of tasks will do, too.
  [[nodiscard]] CLI::Validator Check(bool several = false) const {
    return CLI::Validator(
        [&registry = registry_, several](std::string& word) {
          try {
            if (several)
              static_cast<void>(registry.Describe(word));
            else
              static_cast<void>(registry.Find(word));
            return std::string();
          } catch (const std::invalid_argument& error) {
            return std::string(error.what());
          }
        },
        "");
  }

  [[nodiscard]] std::string Help() const {
    std::string text = "Of these, also by other names:";
    for (const environment::EnvironmentEntry& entry : registry_.entries()) {
      text += " " + entry.spec.short_name();
    }
    return text;
  }

  [[nodiscard]] std::string HelpOfSeveral() const {
    std::string text = "One or several, separated by commas";
    for (const environment::TaskGroup& group : registry_.groups()) text += ", or " + group.name;
    return text + ". " + Help();
  }

 private:
  const environment::EnvironmentRegistry& registry_;
};

void AddEnvironment(CLI::App& app, Typed& typed) {
  CLI::App* environment = app.add_subcommand(
      "environment",
      "Print what an environment is like, in Protobuf text format; without a name "
      "the names of all");
  environment->add_option("NAME", typed.environment.name, "Any name of it")->type_name("");
  environment->footer("Exit status: 0; 2 for a name that is unknown.");
}

void AddRun(CLI::App& app, Typed& typed) {
  CLI::App* run =
      app.add_subcommand("run", "Join a run: play the episodes that its learner assigns");
  run->add_option("--run", typed.run.bus.run_name, "Name of the run")->required();
  run->add_option("--domain", typed.run.bus.domain, "DDS domain, 0 to 232")
      ->transform(text::Number<std::uint32_t>(0, 232))
      ->capture_default_str();
  run->add_option("--envs", typed.run.envs, "Episodes at once, a thread each, 1 to 1024")
      ->transform(text::Number<int>(1, 1024))
      ->capture_default_str();
  kernels::AddIsaOption(*run);
  run->add_option("--network", typed.run.network,
                  "loopback: this machine alone; lan: all interfaces, found by multicast; or peers "
                  "to be found by unicast: HOST[:PORT],...; with tcp the learner's HOST[:PORT]")
      ->capture_default_str();
  run->add_option("--discovery-server", typed.discovery_server,
                  "Fast DDS Discovery Servers that introduce peers in place of multicast, with "
                  "--network lan: HOST[:PORT],... [port 11811]");
  run->add_option(
         "--transport", typed.transport,
         "udp; shm: shared memory between processes of this machine; or tcp: one connection "
         "to the learner")
      ->check(OneOf("transport", {"udp", "shm", "tcp"}))
      ->capture_default_str();
  run->add_option("--security", typed.run.bus.security,
                  "This actor's identity, a folder that deploy/security made, for a run that has "
                  "--security [none]");
  run->add_flag("--stay", typed.run.stay,
                "When the run is finished, wait for the next one of that name; never give up "
                "unless --learner-timeout says so");
  run->add_option("--learner-timeout,--wait", typed.run.learner_timeout,
                  "Seconds without a learner after which to give up (exit 3) [60]")
      ->transform(text::Number<double>(0, 1e9));
  run->add_option("--log-level,--log", typed.run.log.level,
                  "Least severe level to log, to standard error")
      ->type_name("LEVEL")
      ->check(OneOf("level", process::LogLevels()))
      ->capture_default_str();
  run->add_option("--log-format", typed.run.log.format,
                  "Of the log: text, or json: one object a line")
      ->check(OneOf("format", process::LogFormats()))
      ->capture_default_str();
  run->footer(
      "Exit status: 0 the run is finished, 1 refused or failed, 2 bad options or what this machine "
      "lacks (scene files, shared memory, loopback), 3 no learner, 128 + N stopped by "
      "signal N.");
}

void AddTrace(CLI::App& app, const TaskOption& task, Typed& typed) {
  CLI::App* trace = app.add_subcommand(
      "trace", "Print the environment's own numbers for a recorded episode, a CSV row a step");
  trace->add_option("--task", typed.trace.task, task.Help())->required()->check(task.Check());
  trace->add_option("--recording", typed.trace.recording, "Recording, .csv or .csv.gz")->required();
  trace
      ->add_option("--mode", typed.trace.mode,
                   "forced: observe and reward the recorded states; free: start at the recorded "
                   "placement, then only the recorded actions")
      ->required()
      ->check(OneOf("mode", {"forced", "free"}));
}

void AddTasks(CLI::App& app, Typed& typed) {
  CLI::App* tasks = app.add_subcommand("tasks", "List the tasks of Meta-World, a line each");
  tasks->add_option("--picture", typed.tasks.picture,
                    "Draw the scene of each into this PNG file instead");
  tasks->footer(
      "Columns: the task; its family, of alike scenes; how many numbers a placement has (6: object "
      "and goal, 3: object or fixture alone); of the official scripted policy's 10 episodes of 500 "
      "steps the share with success at any step, the share with success at the last one, and the "
      "mean return; what counts as success.");
}

/// A benchmark says which tasks and how many.
void RequireTaskOrBenchmark(const replay::PlacementsOptions& options) {
  if (!options.benchmark.empty()) return;
  if (options.task.empty()) throw CLI::RequiredError("--task (or --benchmark)");
  if (options.mode.empty()) throw CLI::RequiredError("--mode");
}

void AddPlacements(CLI::App& app, const TaskOption& task, Typed& typed) {
  replay::PlacementsOptions& options = typed.placements;
  CLI::App* placements = app.add_subcommand(
      "placements", "Print placements (rand_vec: object xyz, goal xyz), one CSV row each");
  CLI::Option* task_option =
      placements->add_option("--task", options.task, task.Help())->check(task.Check());
  CLI::Option* mode =
      placements
          ->add_option("--mode", options.mode,
                       "random: of training episodes 0, 1, ...; fixed: the one of that seed; mt1: "
                       "the official benchmark's 50")
          ->check(OneOf("mode", {"random", "fixed", "mt1"}));
  placements->add_option("--seed", options.seed, "Run seed")
      ->required()
      ->transform(text::Number<std::uint64_t>());
  CLI::Option* count =
      placements->add_option("--count", options.count, "How many [10 random, 1 fixed, 50 mt1]")
          ->transform(text::Number<std::uint64_t>(1, std::uint64_t{1} << 40));
  placements
      ->add_option("--benchmark", options.benchmark,
                   "In place of --task, --mode and --count: mt10, mt50, ml10 or ml45, the official "
                   "benchmark of many tasks; 50 placements a task, rows begin with task and index, "
                   "of ml10 and ml45 with train or test before them")
      ->excludes(task_option)
      ->excludes(mode)
      ->excludes(count);
  placements->callback([&options] { RequireTaskOrBenchmark(options); });
}

/// Of which episodes, alike for evaluate and render.
void AddPlacementsOf(CLI::App& command, std::uint64_t& seed, std::string& placements) {
  command
      .add_option("--placements", placements,
                  "random: fresh ones, of --seed; mt1: the official MT1 benchmark's 50 of --seed; "
                  "benchmark: "
                  "of several tasks the official benchmark's that --task names; fixed: the one of "
                  "a run with the checkpoint's own seed on that task, as --placements fixed "
                  "trains on")
      ->check(OneOf("placements", {"random", "fixed", "mt1", "benchmark"}))
      ->capture_default_str();
  command
      .add_option("--seed", seed,
                  "Seed of random and official placements, and of the permutations of shuffled "
                  "heads; a fixed "
                  "placement is the same for all")
      ->transform(text::Number<std::uint64_t>())
      ->capture_default_str();
}

void AddEvaluate(CLI::App& app, const TaskOption& task, Typed& typed) {
  play::EvaluateOptions& options = typed.evaluate;
  CLI::App* evaluate = app.add_subcommand(
      "evaluate",
      "Measure a checkpoint's deterministic policy, by default on placements never trained on");
  evaluate->add_option("--checkpoint", options.checkpoint, "Checkpoint file")->required();
  evaluate->add_option("--task", options.task, task.HelpOfSeveral() + " [the checkpoint's]")
      ->check(task.Check(true));
  evaluate
      ->add_option("--episodes", options.episodes,
                   "How many episodes of each task, 1 to 1000000 [50; 1 where fixed placements "
                   "make all the same]")
      ->transform(text::Number<std::int32_t>(1, 1'000'000));
  AddPlacementsOf(*evaluate, options.seed, options.placements);
  evaluate
      ->add_option("--head-order", options.head_order,
                   "Which head acts in each of the k blocks of time, e.g. 0,1,1,3 for k = 4 "
                   "[as in training]")
      ->transform(text::Number<std::uint32_t>())
      ->delimiter(',')
      ->allow_extra_args(false);
  evaluate->add_option("--threads", options.threads, "Episodes at once; 0: as many as cores")
      ->transform(text::Number<std::int32_t>(0, 1024))
      ->capture_default_str();
  kernels::AddIsaOption(*evaluate);
  evaluate->add_flag("--json", options.json, "Print one JSON object");
  evaluate->footer(
      "Each difference from training (task, placements, who acts when, engine, libraries) is a "
      "warning, and in JSON the list `differences`.\n"
      "Exit status: 0; 1 where checkpoint or scenes cannot be used, 2 bad options, 128 + N stopped "
      "by signal N.");
}

void AddRender(CLI::App& app, const TaskOption& task, Typed& typed) {
  render::RenderOptions& options = typed.render;
  CLI::App* render = app.add_subcommand(
      "render",
      "Draw an episode of a checkpoint's deterministic policy: a picture of the hand's "
      "path coloured by head, or a video");
  render->add_option("--checkpoint", options.checkpoint, "Checkpoint file")->required();
  render->add_option(
      "--out", options.out,
      "FILE.png: the whole episode in one picture; FILE.mp4: a video (needs ffmpeg)");
  render->add_option("--csv", options.csv,
                     "File for the path's numbers: step, head, hand, gripper, object, reward, "
                     "success; --out is not needed then");
  render->add_option("--task", options.task, task.Help() + " [the checkpoint's]")
      ->check(task.Check());
  AddPlacementsOf(*render, options.seed, options.placements);
  kernels::AddIsaOption(*render);
  render->add_option("--episode", options.episode, "Which of evaluate's episodes, from 0")
      ->transform(text::Number<std::uint64_t>())
      ->capture_default_str();
  render->add_option("--size", options.size, "WIDTHxHEIGHT in pixels [1280x960; .mp4 640x480]");
  render
      ->add_option("--camera", options.camera,
                   "free: a view that suits the task; AZIMUTH,ELEVATION,DISTANCE[,X,Y,Z]: another "
                   "one (degrees, metres; of the point X,Y,Z); or a camera of the scene")
      ->capture_default_str();
  render->add_flag("--path,!--no-path", options.path, "Draw the hand's path [yes]");
  render
      ->add_option("--arm-opacity", options.arm_opacity,
                   "0 to 1: shows what the arm hides [.png with path 0.4, else 1]")
      ->transform(text::Number<double>(0, 1));
  render->add_option("--step", options.step, ".png: draw the arm as after so many steps [the last]")
      ->transform(text::Number<std::int32_t>());
  render->add_option("--every", options.every, ".mp4: a frame every so many steps, 80 a second")
      ->transform(text::Number<int>(1, 1'000'000))
      ->capture_default_str();
  render->add_option("--speed", options.speed, ".mp4: times real time")
      ->transform(text::Number<double>(0.01, 100))
      ->capture_default_str();
  render->footer(
      "Each difference from training is a warning, as evaluate's. Files are whole or not "
      "there.\n"
      "Exit status: 0; 1 where checkpoint, scene, OpenGL, ffmpeg or the files cannot be used, "
      "2 bad options, 128 + N stopped by signal N.");
}

JoinOptions Judge(Typed typed) {
  typed.run.bus.transport = ParseTransport(typed.transport);
  typed.run.bus.network = ParseNetwork(typed.run.network);
  typed.run.bus.discovery_servers = ParseDiscoveryServers(typed.discovery_server);
  config::CheckRunName(typed.run.bus.run_name);
  CheckBusOptions(typed.run.bus);
  dds::security::CheckIdentity(typed.run.bus, "actor");
  return typed.run;
}

}  // namespace

std::variant<ActorCommand, int> ParseActorCommand(
    int argc, const char* const* argv, const environment::EnvironmentRegistry& registry) {
  CLI::App app("Plays episodes for a Metronome learner, or looks at them.", kProgram);
  app.set_version_flag("--version", process::BuildIdentity() + ", " + process::EngineName());
  app.footer("metronome-actor COMMAND --help says more of a command.");
  Typed typed;
  const TaskOption task(registry);
  AddRun(app, typed);
  AddEnvironment(app, typed);
  AddTasks(app, typed);
  AddTrace(app, task, typed);
  AddPlacements(app, task, typed);
  AddEvaluate(app, task, typed);
  AddRender(app, task, typed);
  if (const auto status = text::ParseCommandLine(app, argc, argv)) return *status;
  if (app.got_subcommand("environment")) return ActorCommand(typed.environment);
  if (app.got_subcommand("tasks")) return ActorCommand(typed.tasks);
  if (app.got_subcommand("trace")) return ActorCommand(typed.trace);
  if (app.got_subcommand("placements")) return ActorCommand(typed.placements);
  if (app.got_subcommand("evaluate")) return ActorCommand(typed.evaluate);
  if (app.got_subcommand("render")) return ActorCommand(typed.render);
  try {
    return ActorCommand(Judge(typed));
  } catch (const std::invalid_argument& error) {
    return text::UsageError(std::string(kProgram) + " run", error.what());
  }
}

}  // namespace metronome::actor
