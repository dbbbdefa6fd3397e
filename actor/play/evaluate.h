#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "actor/environment/registry.h"
#include "common/checkpoint/checkpoint.h"
#include "common/messages/messages.h"
#include "common/policy/head_schedule.h"
#include "common/schema/config.pb.h"

namespace metronome::play {

struct EvaluateOptions {
  std::string checkpoint;
  std::string task;                       // any accepted spelling, several too; empty: the
                                          // checkpoint's
  std::optional<std::int32_t> episodes;   // of each task; none: 50, or all that differ where those
                                          // are fewer
  std::uint64_t seed = 1;                 // of random and mt1 placements and of shuffled heads
  std::string placements = "random";      // random | fixed | mt1 | benchmark
  std::vector<std::uint32_t> head_order;  // [k], who acts in each block; empty: as in training
  bool json = false;
  std::int32_t threads = 0;  // 0: all cores; never changes the result
};

/// One episode under the deterministic policy.
struct EvaluatedEpisode {
  bool success = false;               // at any step
  bool success_end = false;           // at the last step
  std::int32_t steps_to_success = 0;  // steps taken when it first succeeded; 0 if it never did
  std::int32_t length = 0;            // steps
  double episode_return = 0;
};

/// A task's episodes, or those of several tasks.
struct Evaluation {
  std::vector<EvaluatedEpisode> episodes;
  double success = 0;      // share of episodes
  double success_low = 0;  // 95 % Wilson score interval of that share
  double success_high = 0;
  double success_end = 0;
  double success_200 = 0;  // by step 200, where published evaluations of Meta-World end
  double mean_return = 0;
  double mean_length = 0;  // steps
  /// Mean of steps_to_success over the episodes that succeeded; none if none did.
  std::optional<double> time_to_success;
};

/// All that its episodes, at least one, say of it.
Evaluation Summarise(std::vector<EvaluatedEpisode> episodes);

/// @throws std::invalid_argument naming the option that cannot be as it is.
void RequireValid(const EvaluateOptions& options);

/// The configuration that evaluation episodes are played with: the checkpoint's, with the tasks and
/// the placements of `options`; the policy's own (PolicyToEvaluate) has the tasks of its training.
/// @throws std::invalid_argument for an unknown task, and for one whose observations or actions are
/// of another size than the policy's.
RunConfig ConfigToEvaluate(const checkpoint::Checkpoint& checkpoint, const EvaluateOptions& options,
                           const environment::EnvironmentRegistry& registry);

/// The checkpoint's configuration for what plays it: with the horizon and placements of `config`.
RunConfig PolicyToEvaluate(const checkpoint::Checkpoint& checkpoint, const RunConfig& config);

/// A task to be played.
struct PlayedTask {
  std::string name;
  std::size_t environment = 0;  // number among those of the evaluation's configuration
  std::size_t policy = 0;       // number among those that the policy was trained on
};

/// The tasks of an evaluation. A policy of one task plays any; one of several those alone.
/// @param config  from ConfigToEvaluate. @throws std::invalid_argument naming the task.
std::vector<PlayedTask> TasksToPlay(const checkpoint::Checkpoint& checkpoint,
                                    const RunConfig& config,
                                    const environment::EnvironmentRegistry& registry);

/// One line for each difference (training_differences.h).
void Warn(const std::vector<std::string>& differences, std::ostream& err);

/// Wilson score interval of `successes` out of `trials`, at 1.96 standard deviations
/// (Wilson 1927). @throws std::invalid_argument if trials < 1.
void WilsonInterval(std::int64_t successes, std::int64_t trials, double& low, double& high);

/// Where evaluation episode `index` starts: in the evaluation's own streams, which no training run
/// of any seed uses; with fixed placements where training starts.
/// @param config  from ConfigToEvaluate.
environment::EpisodeStart EvaluationStart(const EvaluateOptions& options, const RunConfig& config,
                                          std::uint64_t index);

/// How many evaluation episodes of each task differ from each other: those after them are the same
/// again.
/// std::nullopt: all do. @param config  from ConfigToEvaluate.
std::optional<std::int32_t> DifferentEpisodes(const EvaluateOptions& options,
                                              const RunConfig& config,
                                              const environment::EnvironmentRegistry& registry);

/// The head for each step of evaluation episode `index`: the policy's own schedule, in the
/// evaluation's own streams, or `options.head_order`. @throws std::invalid_argument if the policy
/// has no such order.
/// @param config  from PolicyToEvaluate. @param task  among those of the policy.
policy::HeadSchedule EvaluationSchedule(const EvaluateOptions& options, const RunConfig& config,
                                        std::uint64_t index, std::size_t task);

/// Called after the reset, with t = 0 and an empty outcome, and after each step, with the number t
/// of steps taken so far and what the last of them did.
using StepWatcher = std::function<void(std::int32_t t, const environment::StepOutcome& step)>;

/// Plays one episode with the mean action at every step.
/// @param config    from PolicyToEvaluate. @param schedule  of the episode.
EvaluatedEpisode PlayDeterministic(const RunConfig& config, const PolicySnapshot& snapshot,
                                   const policy::HeadSchedule& schedule,
                                   environment::EpisodeStart start,
                                   environment::Environment& environment,
                                   const StepWatcher& watch = {});

/// `metronome-actor evaluate`: success rate with its confidence interval and mean return of a
/// checkpoint's policy. Each difference from training is a warning on `err`, and `differences`
/// in JSON.
/// @return exit status: 0; 1 where the checkpoint or the scenes cannot be used, 2 for bad options.
int RunEvaluate(const EvaluateOptions& options, const environment::EnvironmentRegistry& registry,
                std::ostream& out, std::ostream& err);

}  // namespace metronome::play
