#include "actor/play/evaluate.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <iomanip>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>
#include <span>
#include <stdexcept>
#include <utility>

#include "actor/play/training_differences.h"
#include "common/config/config_fields.h"
#include "common/policy/network.h"
#include "common/policy/policy.h"
#include "common/process/build_info.h"
#include "common/process/cpu_count.h"
#include "common/process/start_threads.h"
#include "common/text/near_miss.h"

namespace metronome::play {
namespace {

constexpr std::int32_t kEpisodes = 50;
constexpr std::int32_t kPublishedSteps = 200;

std::int32_t EpisodesOf(const EvaluateOptions& options, const RunConfig& config,
                        const environment::EnvironmentRegistry& registry) {
  return options.episodes.value_or(
      std::min(kEpisodes, DifferentEpisodes(options, config, registry).value_or(kEpisodes)));
}

std::int32_t ThreadsFor(const EvaluateOptions& options, std::size_t episodes) {
  return std::min(options.threads > 0 ? options.threads : process::UsableCpus(),
                  static_cast<std::int32_t>(episodes));
}

/// All that an evaluation plays.
struct Plan {
  const EvaluateOptions& options;
  const environment::EnvironmentRegistry& registry;
  const PolicySnapshot& snapshot;
  RunConfig config;  // from ConfigToEvaluate
  RunConfig policy;  // from PolicyToEvaluate
  std::vector<PlayedTask> tasks;
};

/// Holds one environment: episodes come task by task.
class EvaluationPlayer {
 public:
  explicit EvaluationPlayer(const Plan& plan) : plan_(plan) { Enter(plan.tasks.front()); }

  EvaluatedEpisode Play(const PlayedTask& task, std::uint64_t index) {
    Enter(task);
    return PlayDeterministic(plan_.policy, plan_.snapshot,
                             EvaluationSchedule(plan_.options, plan_.policy, index, task.policy),
                             EvaluationStart(plan_.options, plan_.config, index), *environment_);
  }

 private:
  void Enter(const PlayedTask& task) {
    if (environment_ && task.environment == entered_) return;
    environment_ = plan_.registry.Make(plan_.config.environment(), task.environment);
    entered_ = task.environment;
  }

  const Plan& plan_;
  std::unique_ptr<environment::Environment> environment_;
  std::size_t entered_ = 0;
};

// Shares the episodes out over threads; each result goes to its own place. What would be the same
// again is not played again. @return one a task.
std::vector<Evaluation> PlayAll(const Plan& plan) {
  const auto asked = static_cast<std::size_t>(EpisodesOf(plan.options, plan.config, plan.registry));
  const auto different = static_cast<std::size_t>(
      DifferentEpisodes(plan.options, plan.config, plan.registry).value_or(INT32_MAX));
  const std::size_t played = std::min(asked, different);
  std::vector<std::vector<EvaluatedEpisode>> episodes(plan.tasks.size());
  for (auto& of_task : episodes) of_task.resize(asked);
  const auto make_worker = [&]() -> process::Worker {
    return [&, player = std::make_shared<EvaluationPlayer>(plan)](std::size_t i) {
      const std::size_t task = i / played;
      episodes[task][i % played] = player->Play(plan.tasks[task], i % played);
    };
  };
  const std::size_t all = played * plan.tasks.size();
  process::ShareOut(all, static_cast<std::size_t>(ThreadsFor(plan.options, all)), make_worker,
                    "--threads");
  std::vector<Evaluation> evaluations;
  for (auto& of_task : episodes) {
    for (std::size_t i = played; i < asked; ++i) of_task[i] = of_task[i - played];
    evaluations.push_back(Summarise(std::move(of_task)));
  }
  return evaluations;
}

/// Of all episodes of all tasks; as each has equally many, the means over tasks.
Evaluation Together(const std::vector<Evaluation>& evaluations) {
  std::vector<EvaluatedEpisode> all;
  for (const Evaluation& evaluation : evaluations)
    all.insert(all.end(), evaluation.episodes.begin(), evaluation.episodes.end());
  return Summarise(std::move(all));
}

// Before scenes are loaded, and naming the option.
void RequireOrderFits(const EvaluateOptions& options, const RunConfig& policy) {
  try {
    EvaluationSchedule(options, policy, 0, 0);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("--head-order: " + std::string(error.what()));
  }
}

// The interval counts episodes as if they all differed.
void WarnOfRepeats(const EvaluateOptions& options, const RunConfig& config,
                   const environment::EnvironmentRegistry& registry, std::ostream& err) {
  const std::int32_t asked = EpisodesOf(options, config, registry);
  const std::int32_t different = DifferentEpisodes(options, config, registry).value_or(asked);
  if (asked <= different) return;
  err << "warning: " << options.placements << " placements make " << different
      << (different == 1 ? " episode" : " different episodes") << ", the others of --episodes "
      << asked << " are the same again: the interval is too narrow\n";
}

/// As a run is refused them. @throws std::invalid_argument.
void RequirePlacements(const EnvironmentConfig& environment) {
  if (environment.placements() == PLACEMENTS_BENCHMARK && !environment.spec().has_benchmark()) {
    throw std::invalid_argument("--placements benchmark: " + environment.task() +
                                " is none; mt1 has the official placements of each task");
  }
}

/// An evaluation's circumstances, for its report.
struct Report {
  const checkpoint::Checkpoint& checkpoint;
  const EvaluateOptions& options;
  const RunConfig& config;  // of the evaluation
  const std::vector<PlayedTask>& tasks;
  std::vector<std::string> differences;
};

/// What is said of a task as of them all. @param has_success  null where the environment has no
/// word for success.
void AddFigures(const Evaluation& evaluation, bool has_success, nlohmann::ordered_json& json) {
  const auto success = [has_success](double share) {
    return has_success ? nlohmann::ordered_json(share) : nullptr;
  };
  json["success"] = success(evaluation.success);
  json["success_low"] = success(evaluation.success_low);
  json["success_high"] = success(evaluation.success_high);
  json["success_end"] = success(evaluation.success_end);
  json["success_200"] = success(evaluation.success_200);
  json["return"] = evaluation.mean_return;
  json["length"] = evaluation.mean_length;
  json["time_to_success"] = nullptr;
  if (evaluation.time_to_success) json["time_to_success"] = *evaluation.time_to_success;
}

void PrintJson(const std::vector<Evaluation>& evaluations, const Report& report,
               std::ostream& out) {
  const EnvironmentConfig& environment = report.config.environment();
  const bool has_success = environment.spec().has_success();
  const Evaluation evaluation = Together(evaluations);
  nlohmann::ordered_json json;
  json["task"] = environment.task();
  json["version"] = report.checkpoint.state.version;
  json["steps"] = report.checkpoint.state.steps;
  json["episodes"] = evaluation.episodes.size();
  json["placements"] = report.options.placements;
  json["horizon"] = environment.horizon();
  json["goal_visible"] = environment.goal_visible();
  if (!report.options.head_order.empty()) json["head_order"] = report.options.head_order;
  AddFigures(evaluation, has_success, json);
  for (std::size_t i = 0; evaluations.size() > 1 && i < evaluations.size(); ++i) {
    nlohmann::ordered_json& task = json["tasks"][report.tasks[i].name];
    task["episodes"] = evaluations[i].episodes.size();
    AddFigures(evaluations[i], has_success, task);
  }
  json["engine_trained"] = report.checkpoint.engine;
  json["engine_used"] = process::EngineName();
  json["differences"] = report.differences;
  out << json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
}

void PrintTasks(const std::vector<Evaluation>& evaluations, const Report& report,
                std::ostream& out) {
  std::size_t width = 4;
  for (const PlayedTask& task : report.tasks) width = std::max(width, task.name.size());
  const auto row = [&](const std::string& name, const auto&... cells) {
    out << std::left << std::setw(static_cast<int>(width)) << name << std::right;
    ((out << "  " << std::setw(11) << cells), ...);
    out << '\n';
  };
  row("task", "success", "success_end", "return");
  for (std::size_t i = 0; i < evaluations.size(); ++i) {
    row(report.tasks[i].name, evaluations[i].success, evaluations[i].success_end,
        evaluations[i].mean_return);
  }
}

void PrintText(const std::vector<Evaluation>& evaluations, const Report& report,
               std::ostream& out) {
  const EnvironmentConfig& environment = report.config.environment();
  const Evaluation evaluation = Together(evaluations);
  const std::size_t episodes = evaluation.episodes.size();
  out << environment.task() << ", weights version " << report.checkpoint.state.version << " ("
      << report.checkpoint.state.steps << " steps), " << episodes
      << (episodes == 1 ? " episode" : " episodes") << " of "
      << (environment.spec().may_end_early() ? "at most " : "") << environment.horizon()
      << " steps, placements " << report.options.placements << ", goal "
      << (environment.goal_visible() ? "visible" : "hidden") << ", mean action, "
      << process::EngineName() << '\n';
  if (!report.options.head_order.empty()) {
    out << "heads by block";
    for (const std::uint32_t head : report.options.head_order) out << ' ' << head;
    out << '\n';
  }
  if (environment.spec().has_success()) {
    out << "success      " << evaluation.success << "  (95 % interval " << evaluation.success_low
        << " to " << evaluation.success_high << ")\n"
        << "success_end  " << evaluation.success_end << '\n'
        << "success_200  " << evaluation.success_200 << '\n';
  }
  out << "return       " << evaluation.mean_return << '\n';
  if (environment.spec().may_end_early()) {
    out << "length       " << evaluation.mean_length << " steps\n";
  }
  if (evaluation.time_to_success) {
    out << "first success after " << *evaluation.time_to_success << " steps in the mean\n";
  }
  if (evaluations.size() > 1) PrintTasks(evaluations, report, out);
}

}  // namespace

Evaluation Summarise(std::vector<EvaluatedEpisode> episodes) {
  Evaluation evaluation;
  evaluation.episodes = std::move(episodes);
  const auto count = static_cast<double>(evaluation.episodes.size());
  std::int64_t successes = 0;
  std::int64_t successes_end = 0;
  std::int64_t successes_200 = 0;
  std::int64_t steps = 0;
  std::int64_t length = 0;
  double returns = 0;
  for (const EvaluatedEpisode& episode : evaluation.episodes) {
    successes += episode.success ? 1 : 0;
    successes_end += episode.success_end ? 1 : 0;
    successes_200 += episode.success && episode.steps_to_success <= kPublishedSteps ? 1 : 0;
    steps += episode.steps_to_success;
    length += episode.length;
    returns += episode.episode_return;
  }
  evaluation.success = static_cast<double>(successes) / count;
  evaluation.success_end = static_cast<double>(successes_end) / count;
  evaluation.success_200 = static_cast<double>(successes_200) / count;
  evaluation.mean_return = returns / count;
  evaluation.mean_length = static_cast<double>(length) / count;
  if (successes > 0) {
    evaluation.time_to_success = static_cast<double>(steps) / static_cast<double>(successes);
  }
  WilsonInterval(successes, static_cast<std::int64_t>(evaluation.episodes.size()),
                 evaluation.success_low, evaluation.success_high);
  return evaluation;
}

void RequireValid(const EvaluateOptions& options) {
  if (options.episodes && *options.episodes < 1) {
    throw std::invalid_argument("--episodes must be at least 1, not " +
                                std::to_string(*options.episodes));
  }
  const std::vector<std::string> known = config::EnumWords(*Placements_descriptor());
  if (std::find(known.begin(), known.end(), options.placements) == known.end()) {
    throw std::invalid_argument(text::UnknownName("--placements", options.placements, known));
  }
  const bool official = options.placements == "mt1" || options.placements == "benchmark";
  if (official && options.seed > 0xffffffffULL) {
    throw std::invalid_argument("--seed of official placements must be below 2^32");
  }
}

RunConfig ConfigToEvaluate(const checkpoint::Checkpoint& checkpoint, const EvaluateOptions& options,
                           const environment::EnvironmentRegistry& registry) {
  RunConfig config = checkpoint.config;
  config::SetField(config, "environment.placements", options.placements);
  EnvironmentConfig& environment = *config.mutable_environment();
  if (!options.task.empty()) {
    *environment.mutable_spec() = registry.Describe(options.task);
    environment.set_task(environment.spec().short_name());
  }
  RequirePlacements(environment);
  const policy::NetworkShape theirs = policy::ShapeOf(checkpoint.config),
                             ours = policy::ShapeOf(config);
  if (theirs.observation != ours.observation || theirs.action != ours.action) {
    throw std::invalid_argument(
        "--task " + options.task + " has observations of " + std::to_string(ours.observation) +
        " numbers and actions of " + std::to_string(ours.action) + ", the policy is for " +
        std::to_string(theirs.observation) + " and " + std::to_string(theirs.action));
  }
  environment.set_horizon(std::min(environment.horizon(), environment.spec().max_steps()));
  return config;
}

RunConfig PolicyToEvaluate(const checkpoint::Checkpoint& checkpoint, const RunConfig& config) {
  RunConfig policy = checkpoint.config;
  policy.mutable_environment()->set_horizon(config.environment().horizon());
  policy.mutable_environment()->set_placements(config.environment().placements());
  return policy;
}

std::vector<PlayedTask> TasksToPlay(const checkpoint::Checkpoint& checkpoint,
                                    const RunConfig& config,
                                    const environment::EnvironmentRegistry& registry) {
  const EnvironmentConfig& trained = checkpoint.config.environment();
  const auto& known = trained.spec().tasks();
  std::vector<PlayedTask> tasks;
  for (const std::string& name : registry.TasksOf(config.environment().task())) {
    const auto found = std::find(known.begin(), known.end(), name);
    if (!known.empty() && found == known.end()) {
      throw std::invalid_argument("--task " + name + ": the policy was trained on " +
                                  text::JoinNames({known.begin(), known.end()}));
    }
    const auto of_policy = known.empty() ? 0 : found - known.begin();
    tasks.push_back({name, tasks.size(), static_cast<std::size_t>(of_policy)});
  }
  return tasks;
}

void Warn(const std::vector<std::string>& differences, std::ostream& err) {
  for (const std::string& difference : differences) err << "warning: " << difference << '\n';
}

void WilsonInterval(std::int64_t successes, std::int64_t trials, double& low, double& high) {
  if (trials < 1) throw std::invalid_argument("an interval needs at least one trial");
  const double z = 1.959963984540054;
  const auto n = static_cast<double>(trials);
  const double share = static_cast<double>(successes) / n;
  const double centre = (share + z * z / (2 * n)) / (1 + z * z / n);
  const double half =
      z / (1 + z * z / n) * std::sqrt(share * (1 - share) / n + z * z / (4 * n * n));
  low = std::max(0.0, centre - half);
  high = std::min(1.0, centre + half);
}

environment::EpisodeStart EvaluationStart(const EvaluateOptions& options, const RunConfig& config,
                                          std::uint64_t index) {
  if (config.environment().placements() == PLACEMENTS_FIXED)
    return environment::TrainingStart(config, 0);
  return environment::EpisodeStart({numbers::RandomPurpose::kEvaluate, options.seed, index});
}

std::optional<std::int32_t> DifferentEpisodes(const EvaluateOptions& options,
                                              const RunConfig& config,
                                              const environment::EnvironmentRegistry& registry) {
  const PolicyConfig& policy = config.policy();
  const std::string task = registry.TasksOf(config.environment().task()).front();
  if (policy.schedule() == SCHEDULE_SHUFFLED && policy.heads() > 1 && options.head_order.empty()) {
    return std::nullopt;
  }
  if (config.environment().placements() == PLACEMENTS_FIXED) return 1;
  const auto& different_starts = registry.Find(task).different_starts;
  return different_starts ? different_starts(config.environment()) : std::nullopt;
}

policy::HeadSchedule EvaluationSchedule(const EvaluateOptions& options, const RunConfig& config,
                                        std::uint64_t index, std::size_t task) {
  if (!options.head_order.empty()) return {config, options.head_order, task};
  return {config, numbers::EpisodeKey{numbers::RandomPurpose::kEvaluate, options.seed, index},
          task};
}

EvaluatedEpisode PlayDeterministic(const RunConfig& config, const PolicySnapshot& snapshot,
                                   const policy::HeadSchedule& schedule,
                                   environment::EpisodeStart start,
                                   environment::Environment& environment,
                                   const StepWatcher& watch) {
  policy::Policy policy(config, snapshot);
  EvaluatedEpisode result;
  std::vector<float> observation(std::size_t(config.environment().spec().observation_size()));
  const auto actions = std::size_t(config.environment().spec().action_size());
  environment.Reset(start, observation);
  if (watch) watch(0, {});
  for (bool ended = false; !ended;) {
    const policy::Policy::Action action = policy.Mean(schedule, observation.data(), result.length);
    const environment::StepOutcome step =
        environment.Step(std::span(action).first(actions), observation);
    ++result.length;
    if (watch) watch(result.length, step);
    result.episode_return += step.reward;
    result.success_end = step.success;
    if (step.success && !result.success) result.steps_to_success = result.length;
    result.success = result.success || step.success;
    ended = step.terminated || step.truncated || result.length == schedule.horizon();
  }
  return result;
}

int RunEvaluate(const EvaluateOptions& options, const environment::EnvironmentRegistry& registry,
                std::ostream& out, std::ostream& err) {
  try {
    RequireValid(options);
    const checkpoint::Checkpoint checkpoint = checkpoint::LoadCheckpoint(
        options.checkpoint, [&registry](const auto& name) { return registry.Describe(name); });
    const RunConfig config = ConfigToEvaluate(checkpoint, options, registry);
    const Plan plan{options,
                    registry,
                    checkpoint.state.policy,
                    config,
                    PolicyToEvaluate(checkpoint, config),
                    TasksToPlay(checkpoint, config, registry)};
    RequireOrderFits(options, plan.policy);
    if (const auto many = process::TooManyThreads(options.threads, "--threads")) {
      err << "warning: " << *many << '\n';
    }
    const Report report{checkpoint, options, config, plan.tasks,
                        DifferencesFromTraining(checkpoint, options, config)};
    Warn(report.differences, err);
    WarnOfRepeats(options, config, registry, err);
    const std::vector<Evaluation> evaluations = PlayAll(plan);
    if (options.json) {
      PrintJson(evaluations, report, out);
    } else {
      PrintText(evaluations, report, out);
    }
    out << std::flush;
    if (!out) throw std::runtime_error("cannot write the result to standard output");
    return 0;
  } catch (const std::invalid_argument& error) {
    err << "error: " << error.what() << '\n';
    return 2;
  } catch (const std::exception& error) {
    err << "error: " << error.what() << '\n';
    return 1;
  }
}

}  // namespace metronome::play
