#include "actor/evaluate.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <exception>
#include <mutex>
#include <nlohmann/json.hpp>
#include <ostream>
#include <stdexcept>
#include <thread>

#include "actor/metaworld/assets.h"
#include "actor/metaworld/placement.h"
#include "actor/metaworld/task_table.h"
#include "common/build_info.h"
#include "common/policy.h"
#include "common/random.h"
#include "common/snapshot.h"
#include "common/start_threads.h"

namespace metronome {
namespace {

using Float39 = std::array<float, kObservationSize>;

Float39 AsPolicySees(const metaworld::Observation& observation) {
  Float39 result{};
  std::transform(observation.begin(), observation.end(), result.begin(),
                 [](double value) { return static_cast<float>(value); });
  return result;
}

void Summarise(Evaluation& evaluation) {
  const auto count = static_cast<double>(evaluation.episodes.size());
  std::int64_t successes = 0;
  std::int64_t successes_end = 0;
  std::int64_t steps = 0;
  double returns = 0;
  for (const EvaluatedEpisode& episode : evaluation.episodes) {
    successes += episode.success ? 1 : 0;
    successes_end += episode.success_end ? 1 : 0;
    steps += episode.steps_to_success;
    returns += episode.episode_return;
  }
  evaluation.success = static_cast<double>(successes) / count;
  evaluation.success_end = static_cast<double>(successes_end) / count;
  evaluation.mean_return = returns / count;
  if (successes > 0) {
    evaluation.time_to_success = static_cast<double>(steps) / static_cast<double>(successes);
  }
  WilsonInterval(successes, static_cast<std::int64_t>(evaluation.episodes.size()),
                 evaluation.success_low, evaluation.success_high);
}

// Shares the episodes out over threads; each result goes to its own place.
Evaluation PlayAll(const EvaluateOptions& options, const RunConfig& config,
                   const PolicySnapshot& snapshot) {
  const std::string& task = config.environment().task();
  metaworld::EnvironmentOptions environment_options;
  environment_options.goal_visible = config.environment().goal_visible();
  environment_options.assets =
      options.assets.empty() ? metaworld::DefaultAssetsPath() : options.assets;
  Evaluation evaluation;
  evaluation.episodes.resize(static_cast<std::size_t>(options.episodes));
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&](std::size_t /*thread*/) {
    try {
      const auto environment = metaworld::MakeEnvironment(task, environment_options);
      for (std::size_t i = next++; i < evaluation.episodes.size(); i = next++) {
        evaluation.episodes[i] =
            PlayDeterministic(config, snapshot, EvaluationSchedule(options, config, i),
                              EvaluationPlacement(options, task, i), *environment);
      }
    } catch (...) {
      const std::lock_guard lock(failure_mutex);
      failure = std::current_exception();
    }
  };
  const auto cores = static_cast<std::int32_t>(std::max(1U, std::thread::hardware_concurrency()));
  const std::int32_t wanted =
      std::min(options.threads > 0 ? options.threads : cores, options.episodes);
  std::vector<std::thread> threads = StartThreads(
      static_cast<std::size_t>(wanted), work, [&] { next = evaluation.episodes.size(); },
      "--threads");
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
  Summarise(evaluation);
  return evaluation;
}

// Before scenes are loaded, and naming the option.
void RequireOrderFits(const EvaluateOptions& options, const RunConfig& config) {
  try {
    EvaluationSchedule(options, config, 0);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("--head-order: " + std::string(error.what()));
  }
}

void PrintJson(const Evaluation& evaluation, const Checkpoint& checkpoint, const std::string& task,
               const std::vector<std::uint32_t>& head_order, std::ostream& out) {
  nlohmann::ordered_json json;
  json["task"] = task;
  json["version"] = checkpoint.state.version;
  json["steps"] = checkpoint.state.steps;
  json["episodes"] = evaluation.episodes.size();
  if (!head_order.empty()) json["head_order"] = head_order;
  json["success"] = evaluation.success;
  json["success_low"] = evaluation.success_low;
  json["success_high"] = evaluation.success_high;
  json["success_end"] = evaluation.success_end;
  json["return"] = evaluation.mean_return;
  json["time_to_success"] = nullptr;
  if (evaluation.time_to_success) json["time_to_success"] = *evaluation.time_to_success;
  json["engine_trained"] = checkpoint.engine;
  json["engine_used"] = EngineName();
  out << json.dump(2) << '\n';
}

void PrintText(const Evaluation& evaluation, const Checkpoint& checkpoint, const std::string& task,
               const std::vector<std::uint32_t>& head_order, std::ostream& out) {
  out << task << ", weights version " << checkpoint.state.version << " (" << checkpoint.state.steps
      << " steps), " << evaluation.episodes.size() << " episodes, mean action, " << EngineName()
      << '\n';
  if (!head_order.empty()) {
    out << "heads by block";
    for (const std::uint32_t head : head_order) out << ' ' << head;
    out << '\n';
  }
  out << "success      " << evaluation.success << "  (95 % interval " << evaluation.success_low
      << " to " << evaluation.success_high << ")\n"
      << "success_end  " << evaluation.success_end << '\n'
      << "return       " << evaluation.mean_return << '\n';
  if (evaluation.time_to_success) {
    out << "first success after " << *evaluation.time_to_success << " steps in the mean\n";
  }
}

}  // namespace

void RequireValid(const EvaluateOptions& options) {
  if (options.episodes < 1) {
    throw std::invalid_argument("--episodes must be at least 1, not " +
                                std::to_string(options.episodes));
  }
  if (options.placements != "random" && options.placements != "mt1") {
    throw std::invalid_argument("--placements '" + options.placements +
                                "' is not one of: random, mt1");
  }
  if (options.placements == "mt1" && options.seed > 0xffffffffULL) {
    throw std::invalid_argument("--seed of mt1 placements must be below 2^32");
  }
}

RunConfig ConfigToEvaluate(const Checkpoint& checkpoint, const std::string& task,
                           std::ostream& err) {
  RunConfig config = checkpoint.config;
  if (!task.empty()) config.mutable_environment()->set_task(metaworld::FindTask(task).name);
  const std::string& played = config.environment().task();
  const std::string& trained = checkpoint.config.environment().task();
  if (played != trained) {
    err << "warning: a policy trained on " << trained << " is evaluated on " << played << '\n';
  }
  if (checkpoint.engine != EngineName()) {
    err << "warning: a policy trained on " << checkpoint.engine << " is evaluated on "
        << EngineName() << '\n';
  }
  return config;
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

metaworld::RandVec EvaluationPlacement(const EvaluateOptions& options, const std::string& task,
                                       std::uint64_t index) {
  const metaworld::TaskSpec& spec = metaworld::FindTask(task);
  if (options.placements == "mt1") {
    const auto official = metaworld::Mt1Placements(spec, static_cast<std::uint32_t>(options.seed));
    return official.at(index % official.size());
  }
  RandomStream stream(RandomPurpose::kEvaluate, options.seed, index, kPlacementDraw);
  return metaworld::DrawPlacement(spec, stream);
}

HeadSchedule EvaluationSchedule(const EvaluateOptions& options, const RunConfig& config,
                                std::uint64_t index) {
  if (!options.head_order.empty()) return {config, options.head_order};
  return {config, EpisodeKey{RandomPurpose::kEvaluate, options.seed, index}};
}

EvaluatedEpisode PlayDeterministic(const RunConfig& config, const PolicySnapshot& snapshot,
                                   const HeadSchedule& schedule,
                                   const metaworld::RandVec& placement,
                                   metaworld::Environment& environment, const StepWatcher& watch) {
  Policy policy(config, snapshot);
  EvaluatedEpisode result;
  metaworld::StepResult start;
  start.observation = environment.Reset(placement);
  if (watch) watch(0, start);
  Float39 observation = AsPolicySees(start.observation);
  for (std::int32_t t = 0; t < schedule.horizon(); ++t) {
    const metaworld::StepResult step =
        environment.Step(policy.Mean(schedule, observation.data(), t));
    if (watch) watch(t + 1, step);
    observation = AsPolicySees(step.observation);
    result.episode_return += step.reward;
    result.success_end = step.info.success;
    if (step.info.success && !result.success) result.steps_to_success = t + 1;
    result.success = result.success || step.info.success;
  }
  return result;
}

int RunEvaluate(const EvaluateOptions& options, std::ostream& out, std::ostream& err) {
  try {
    RequireValid(options);
    const Checkpoint checkpoint = LoadCheckpoint(options.checkpoint);
    const RunConfig config = ConfigToEvaluate(checkpoint, options.task, err);
    const std::string& task = config.environment().task();
    RequireOrderFits(options, config);
    const Evaluation evaluation = PlayAll(options, config, SnapshotOf(checkpoint.state, config));
    if (options.json) {
      PrintJson(evaluation, checkpoint, task, options.head_order, out);
    } else {
      PrintText(evaluation, checkpoint, task, options.head_order, out);
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

}  // namespace metronome
