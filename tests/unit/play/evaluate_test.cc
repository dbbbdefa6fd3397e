#include "actor/play/evaluate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <set>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "actor/metaworld/placement.h"
#include "actor/metaworld/tasks/environments.h"
#include "actor/metaworld/tasks/task_table.h"
#include "actor/play/rollout.h"
#include "actor/play/training_differences.h"
#include "common/config/config.h"
#include "common/numbers/random.h"
#include "common/policy/head_schedule.h"
#include "common/policy/network.h"
#include "common/process/build_info.h"
#include "tests/unit/support/environments.h"

namespace metronome::play {
namespace {

const environment::EnvironmentRegistry& Registry() {
  static const environment::EnvironmentRegistry registry(metaworld::tasks::Environments());
  return registry;
}

metaworld::RandVec PlacementAt(const RunConfig& config, environment::EpisodeStart start) {
  return metaworld::StartPlacement(metaworld::tasks::FindTask(config.environment().task()),
                                   config.environment().placements(), start);
}

metaworld::RandVec TrainingPlacement(const RunConfig& config, std::uint64_t number) {
  return PlacementAt(config, environment::TrainingStart(config, number));
}

metaworld::RandVec EvaluationPlacement(const EvaluateOptions& options, const RunConfig& config,
                                       std::uint64_t index) {
  return PlacementAt(config, EvaluationStart(options, config, index));
}

// Values of the textbook example (Wilson 1927; Newcombe 1998, table I): 81 of 263, 15 of 148, 0 of
// 20, 1 of 29.
TEST(WilsonIntervalTest, AgreesWithPublishedValues) {
  double low = 0;
  double high = 0;
  WilsonInterval(81, 263, low, high);
  EXPECT_NEAR(low, 0.2553, 5e-5);
  EXPECT_NEAR(high, 0.3662, 5e-5);
  WilsonInterval(15, 148, low, high);
  EXPECT_NEAR(low, 0.0624, 5e-5);
  EXPECT_NEAR(high, 0.1605, 5e-5);
  WilsonInterval(0, 20, low, high);
  EXPECT_NEAR(low, 0.0, 5e-5);
  EXPECT_NEAR(high, 0.1611, 5e-5);
  WilsonInterval(1, 29, low, high);
  EXPECT_NEAR(low, 0.0061, 5e-5);
  EXPECT_NEAR(high, 0.1718, 5e-5);
  EXPECT_THROW(WilsonInterval(0, 0, low, high), std::invalid_argument);
}

TEST(EvaluationPlacementTest, IsDrawnByNoTrainingRun) {
  EvaluateOptions options;
  RunConfig config;
  test::SetTask(config, "push");
  std::set<metaworld::RandVec> evaluation;
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    options.seed = seed;
    for (std::uint64_t i = 0; i < 50; ++i) {
      evaluation.insert(EvaluationPlacement(options, config, i));
    }
  }
  EXPECT_EQ(evaluation.size(), 150U);
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    config.set_seed(seed);
    for (std::uint64_t number = 0; number < 50; ++number) {
      EXPECT_EQ(evaluation.count(TrainingPlacement(config, number)), 0U);
    }
  }
}

TEST(TrainingPlacementTest, FixedIsOneForTheRunAndRandomOneForEachEpisode) {
  RunConfig config;
  test::SetTask(config, "box-close");
  EXPECT_NE(TrainingPlacement(config, 0), TrainingPlacement(config, 1));
  EXPECT_EQ(TrainingPlacement(config, 7), TrainingPlacement(config, 7));
  config.mutable_environment()->set_placements(PLACEMENTS_FIXED);
  EXPECT_EQ(TrainingPlacement(config, 0), TrainingPlacement(config, 1));
  const auto of_seed_one = TrainingPlacement(config, 0);
  config.set_seed(2);
  EXPECT_NE(TrainingPlacement(config, 0), of_seed_one);
}

checkpoint::Checkpoint TrainedOn(Placements placements, std::uint64_t seed) {
  checkpoint::Checkpoint checkpoint;
  checkpoint.config.set_seed(seed);
  test::SetTask(checkpoint.config, "push");
  checkpoint.config.mutable_environment()->set_placements(placements);
  checkpoint.config = config::Resolve(checkpoint.config);
  checkpoint.engine = process::EngineName();
  checkpoint.build = process::BuildIdentity();
  return checkpoint;
}

EvaluateOptions With(const std::string& placements, std::uint64_t seed) {
  EvaluateOptions options;
  options.placements = placements;
  options.seed = seed;
  return options;
}

std::vector<std::string> Differences(const checkpoint::Checkpoint& checkpoint,
                                     const EvaluateOptions& options) {
  return DifferencesFromTraining(checkpoint, options,
                                 ConfigToEvaluate(checkpoint, options, Registry()));
}

TEST(EvaluationPlacementTest, FixedIsTheRunsOwnWhateverTheEvaluationsSeed) {
  const checkpoint::Checkpoint checkpoint = TrainedOn(PLACEMENTS_FIXED, 7);
  const auto own = TrainingPlacement(checkpoint.config, 12);
  for (const std::uint64_t seed : {1U, 8U}) {
    EvaluateOptions options = With("fixed", seed);
    const RunConfig config = ConfigToEvaluate(checkpoint, options, Registry());
    EXPECT_EQ(EvaluationPlacement(options, config, 0), own);
    EXPECT_EQ(EvaluationPlacement(options, config, 3), own);
    options.task = "box-close-v3";
    RunConfig elsewhere = checkpoint.config;
    test::SetTask(elsewhere, "box-close");
    EXPECT_EQ(EvaluationPlacement(options, ConfigToEvaluate(checkpoint, options, Registry()), 0),
              TrainingPlacement(elsewhere, 0));
  }
}

TEST(DifferentEpisodesTest, FixedPlacementsMakeOneUnlessHeadsAreShuffled) {
  checkpoint::Checkpoint checkpoint = TrainedOn(PLACEMENTS_FIXED, 7);
  EvaluateOptions options = With("fixed", 1);
  EXPECT_EQ(
      DifferentEpisodes(options, ConfigToEvaluate(checkpoint, options, Registry()), Registry()), 1);
  options.placements = "mt1";
  EXPECT_EQ(
      DifferentEpisodes(options, ConfigToEvaluate(checkpoint, options, Registry()), Registry()),
      50);
  options.placements = "random";
  EXPECT_EQ(
      DifferentEpisodes(options, ConfigToEvaluate(checkpoint, options, Registry()), Registry()),
      std::nullopt);
  options.placements = "fixed";
  checkpoint.config.mutable_policy()->set_schedule(SCHEDULE_SHUFFLED);
  EXPECT_EQ(
      DifferentEpisodes(options, ConfigToEvaluate(checkpoint, options, Registry()), Registry()),
      std::nullopt);
  options.head_order = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  EXPECT_EQ(
      DifferentEpisodes(options, ConfigToEvaluate(checkpoint, options, Registry()), Registry()), 1);
}

TEST(DifferencesFromTrainingTest, AreNoneWhereAllIsAsInTraining) {
  EXPECT_TRUE(Differences(TrainedOn(PLACEMENTS_RANDOM, 7), With("random", 1)).empty());
  EXPECT_TRUE(Differences(TrainedOn(PLACEMENTS_FIXED, 7), With("fixed", 1)).empty());
  EXPECT_TRUE(Differences(TrainedOn(PLACEMENTS_MT1, 7), With("mt1", 7)).empty());
  EvaluateOptions own_blocks = With("random", 1);
  own_blocks.head_order = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  EXPECT_TRUE(Differences(TrainedOn(PLACEMENTS_RANDOM, 7), own_blocks).empty());
}

TEST(DifferencesFromTrainingTest, AreNamedWithTheOptionsThatPlayAsInTraining) {
  using Sentences = std::vector<std::string>;
  EXPECT_EQ(Differences(TrainedOn(PLACEMENTS_FIXED, 7), With("random", 1)),
            Sentences{"trained with placements fixed, evaluated with placements random (as in "
                      "training: --placements fixed)"});
  EXPECT_EQ(Differences(TrainedOn(PLACEMENTS_MT1, 7), With("random", 1)),
            Sentences{"trained with placements mt1, evaluated with placements random (as in "
                      "training: --placements mt1 --seed 7)"});
  EXPECT_EQ(Differences(TrainedOn(PLACEMENTS_MT1, 7), With("mt1", 1)),
            Sentences{"trained on the mt1 placements of seed 7, evaluated on those of seed 1 (as "
                      "in training: --seed 7)"});
}

TEST(DifferencesFromTrainingTest, AreAllNamed) {
  checkpoint::Checkpoint checkpoint = TrainedOn(PLACEMENTS_FIXED, 7);
  checkpoint.engine = "mujoco-1";
  checkpoint.build = "metronome 0.0.9, gcc 1, -O1, eigen 3.4.0, glibc 1";
  EvaluateOptions options = With("random", 1);
  options.task = "assembly";
  options.head_order = {9, 1, 2, 3, 4, 5, 6, 7, 8, 0};
  RunConfig played = ConfigToEvaluate(checkpoint, options, Registry());
  played.mutable_environment()->set_horizon(400);
  played.mutable_environment()->set_goal_visible(false);
  std::string all;
  for (const std::string& sentence : DifferencesFromTraining(checkpoint, options, played)) {
    all += sentence + '\n';
  }
  for (const char* words :
       {"task push, evaluated with task assembly", "placements fixed", "horizon 500, evaluated",
        "goal_visible true, evaluated", "in the order 9, 1, 2, 3, 4, 5, 6, 7, 8, 0",
        "on mujoco-1, evaluated", "with glibc 1, evaluated with glibc "}) {
    EXPECT_NE(all.find(words), std::string::npos) << words << " in\n" << all;
  }
  for (const char* words : {"metronome 0.0.9", "gcc", "-O1"}) {
    EXPECT_EQ(all.find(words), std::string::npos) << words << ", which alone changes no bit";
  }
}

TEST(DifferencesFromTrainingTest, ABuildThatDidNotNameAllItsPartsIsNoOther) {
  checkpoint::Checkpoint checkpoint = TrainedOn(PLACEMENTS_RANDOM, 7);
  const std::size_t part = checkpoint.build.find(", sleef");
  checkpoint.build.erase(part, checkpoint.build.find(", glibc") - part);
  EXPECT_TRUE(Differences(checkpoint, With("random", 1)).empty());
}

/// Succeeds at the steps (counted from 1) that it is told to, pays a reward of 1 a step, and ends
/// after `length` steps.
class ScriptedEnvironment : public environment::Environment {
 public:
  explicit ScriptedEnvironment(std::set<int> successes, int length = 1000, bool terminates = false)
      : successes_(std::move(successes)), length_(length), terminates_(terminates) {}
  void Reset(environment::EpisodeStart& /*start*/, std::span<float> observation) override {
    step_ = 0;
    std::fill(observation.begin(), observation.end(), 0.0F);
  }
  environment::StepOutcome Step(std::span<const float> /*action*/,
                                std::span<float> /*observation*/) override {
    ++step_;
    const bool ends = step_ == length_;
    return {.reward = 1,
            .success = successes_.count(step_) > 0,
            .terminated = ends && terminates_,
            .truncated = ends && !terminates_};
  }

 private:
  std::set<int> successes_;
  int length_;
  bool terminates_;
  int step_ = 0;
};

const environment::EpisodeStart kStart({numbers::RandomPurpose::kEvaluate, 1, 0});

EvaluatedEpisode PlayWithSuccessesAt(std::set<int> steps, int length = 1000) {
  RunConfig given;
  test::SetTask(given, "push");
  given.mutable_environment()->set_horizon(20);
  const RunConfig config = config::Resolve(given);
  PolicySnapshot snapshot;
  snapshot.parameters.resize(policy::ActorLayout(policy::ShapeOf(config)).size);
  snapshot.observation_mean.resize(test::kObservationSize);
  snapshot.observation_inv_std.resize(test::kObservationSize);
  ScriptedEnvironment environment(std::move(steps), length);
  return PlayDeterministic(config, snapshot, EvaluationSchedule({}, config, 0, 0), kStart,
                           environment);
}

TEST(PlayDeterministicTest, CountsStepsToTheFirstSuccess) {
  const EvaluatedEpisode lost_again = PlayWithSuccessesAt({7, 8, 15});
  EXPECT_TRUE(lost_again.success);
  EXPECT_FALSE(lost_again.success_end);
  EXPECT_EQ(lost_again.steps_to_success, 7);
  EXPECT_EQ(lost_again.episode_return, 20);
  const EvaluatedEpisode at_the_end = PlayWithSuccessesAt({20});
  EXPECT_TRUE(at_the_end.success_end);
  EXPECT_EQ(at_the_end.steps_to_success, 20);
  const EvaluatedEpisode never = PlayWithSuccessesAt({});
  EXPECT_FALSE(never.success);
  EXPECT_EQ(never.steps_to_success, 0);
  EXPECT_EQ(never.length, 20);
}

TEST(PlayDeterministicTest, AnEpisodeThatTheEnvironmentEndsIsShorter) {
  const EvaluatedEpisode cut = PlayWithSuccessesAt({7}, 7);
  EXPECT_EQ(cut.length, 7);
  EXPECT_EQ(cut.episode_return, 7);
  EXPECT_TRUE(cut.success_end);
}

EvaluatedEpisode SuccessAfter(std::int32_t steps) {
  EvaluatedEpisode episode;
  episode.success = steps > 0;
  episode.steps_to_success = steps;
  return episode;
}

TEST(SummariseTest, SuccessByStep200IsOfEpisodesThatSucceedInTime) {
  const Evaluation evaluation =
      Summarise({SuccessAfter(200), SuccessAfter(201), SuccessAfter(0), SuccessAfter(1)});
  EXPECT_EQ(evaluation.success, 0.75);
  EXPECT_EQ(evaluation.success_200, 0.5);
  EXPECT_EQ(evaluation.time_to_success, 134);
}

/// Remembers the actions; the observation after t steps is t everywhere.
class RecordingEnvironment final : public environment::Environment {
 public:
  void Reset(environment::EpisodeStart& /*start*/, std::span<float> observation) override {
    actions.clear();
    std::fill(observation.begin(), observation.end(), 0.0F);
  }
  environment::StepOutcome Step(std::span<const float> action,
                                std::span<float> observation) override {
    actions.emplace_back(action.begin(), action.end());
    std::fill(observation.begin(), observation.end(), float(actions.size()));
    return {};
  }

  std::vector<std::vector<float>> actions;
};

/// A policy whose action is its head: all weights are zero, head j's biases are j.
struct HeadsAsActions {
  explicit HeadsAsActions(Schedule schedule) {
    config.set_seed(3);
    test::SetTask(config, "push");
    config.mutable_environment()->set_horizon(40);
    config.mutable_policy()->set_heads(5);
    config.mutable_policy()->add_hidden(4);
    config.mutable_policy()->set_schedule(schedule);
    const policy::MlpLayout layout = policy::ActorLayout(policy::ShapeOf(config));
    snapshot.parameters.assign(layout.size, 0.0F);
    for (std::size_t i = 0; i < 20; ++i) {
      const std::size_t head = i / 4;
      snapshot.parameters[layout.head.bias + i] = float(head);
      snapshot.parameters[layout.log_std + i] = -80;
    }
    snapshot.observation_mean.assign(test::kObservationSize, 0.0F);
    snapshot.observation_inv_std.assign(test::kObservationSize, 1.0F);
  }

  RunConfig config;
  PolicySnapshot snapshot;
};

std::vector<std::int32_t> HeadsOf(const RecordingEnvironment& environment) {
  std::vector<std::int32_t> heads;
  for (const std::vector<float>& action : environment.actions) {
    heads.push_back(static_cast<std::int32_t>(std::lround(action[0])));
  }
  return heads;
}

TEST(PlayDeterministicTest, HeadsFollowTheScheduleAndTheEvaluationsOwnPermutations) {
  RecordingEnvironment environment;
  for (const Schedule schedule : {SCHEDULE_BLOCKS, SCHEDULE_INTERLEAVED, SCHEDULE_SHUFFLED}) {
    const HeadsAsActions policy(schedule);
    EvaluateOptions options;
    options.seed = 9;
    PlayDeterministic(policy.config, policy.snapshot,
                      EvaluationSchedule(options, policy.config, 2, 0), kStart, environment);
    const auto permutation = numbers::Permutation(
        5, {numbers::RandomPurpose::kHeadPermutation, 9, 2, 2 /* kEvaluate */});
    const std::vector<std::int32_t> heads = HeadsOf(environment);
    ASSERT_EQ(heads.size(), 40U);
    for (std::int32_t t = 0; t < 40; ++t) {
      const std::int32_t block = t / 8;
      const std::int32_t want = schedule == SCHEDULE_BLOCKS ? block
                                : schedule == SCHEDULE_INTERLEAVED
                                    ? t % 5
                                    : std::int32_t(permutation[block]);
      EXPECT_EQ(heads[t], want) << "t=" << t;
    }
  }
}

TEST(PlayDeterministicTest, HeadsFollowTheOrderThatIsAskedFor) {
  RecordingEnvironment environment;
  EvaluateOptions options;
  options.head_order = {4, 1, 1, 3, 0};
  for (const Schedule schedule : {SCHEDULE_BLOCKS, SCHEDULE_SHUFFLED}) {
    const HeadsAsActions policy(schedule);
    PlayDeterministic(policy.config, policy.snapshot,
                      EvaluationSchedule(options, policy.config, 2, 0), kStart, environment);
    const std::vector<std::int32_t> heads = HeadsOf(environment);
    ASSERT_EQ(heads.size(), 40U);
    for (std::size_t t = 0; t < 40; ++t) {
      EXPECT_EQ(heads[t], std::int32_t(options.head_order[t / 8])) << "t=" << t;
    }
  }
}

TEST(PlayEpisodeTest, TagsAndActionsAreThoseOfTheSchedulesHeads) {
  RecordingEnvironment environment;
  const std::atomic<bool> cancel{false};
  for (const Schedule schedule : {SCHEDULE_BLOCKS, SCHEDULE_INTERLEAVED, SCHEDULE_SHUFFLED}) {
    const HeadsAsActions policy(schedule);
    const auto episode = PlayEpisode(policy.config, policy.snapshot, 17, environment, cancel);
    ASSERT_TRUE(episode);
    const policy::HeadSchedule heads(policy.config, {numbers::RandomPurpose::kTrain, 3, 17}, 0);
    for (std::int32_t t = 0; t < 40; ++t) {
      EXPECT_EQ(episode->head[t], heads.HeadAt(t));
      EXPECT_EQ(HeadsOf(environment)[t], heads.HeadAt(t));
    }
  }
}

TEST(PlayEpisodeTest, EndsWhereTheEnvironmentEndsAndSaysWhy) {
  HeadsAsActions policy(SCHEDULE_BLOCKS);
  policy.config.mutable_environment()->mutable_spec()->set_may_end_early(true);
  const std::atomic<bool> cancel{false};
  const auto end_of = [&](int length, bool terminates) {
    ScriptedEnvironment environment({}, length, terminates);
    const auto episode = PlayEpisode(policy.config, policy.snapshot, 17, environment, cancel);
    EXPECT_EQ(episode->observation.size(), std::size_t(episode->length() + 1) * 39);
    EXPECT_EQ(episode->action.size(), std::size_t(episode->length()) * 4);
    return std::pair(episode->length(), int(episode->flags.back()));
  };
  EXPECT_EQ(end_of(7, true), std::pair(7, int(kStepTerminated)));
  EXPECT_EQ(end_of(7, false), std::pair(7, int(kStepTruncated)));
  EXPECT_EQ(end_of(40, true), std::pair(40, int(kStepTerminated)));
  EXPECT_EQ(end_of(40, false), std::pair(40, int(kStepTruncated)));
  EXPECT_EQ(end_of(1000, false), std::pair(40, int(kStepTruncated))) << "the horizon ends it";
  policy.config.mutable_environment()->mutable_spec()->set_may_end_early(false);
  ScriptedEnvironment environment({}, 7);
  EXPECT_THROW(PlayEpisode(policy.config, policy.snapshot, 17, environment, cancel),
               std::logic_error);
}

TEST(RunEvaluateTest, NamesWhatIsWrongWithItsOptions) {
  const auto fail = [](const EvaluateOptions& options, int want) {
    std::ostringstream out;
    std::ostringstream err;
    EXPECT_EQ(RunEvaluate(options, Registry(), out, err), want);
    EXPECT_EQ(out.str(), "");
    return err.str();
  };
  EvaluateOptions options;
  options.checkpoint = "no-such-file.ckpt";
  EXPECT_NE(fail(options, 1).find("no-such-file.ckpt"), std::string::npos);
  options.episodes = 0;
  EXPECT_NE(fail(options, 2).find("--episodes"), std::string::npos);
  options.episodes = 1;
  options.placements = "mt2";
  EXPECT_NE(fail(options, 2).find("random, fixed, mt1"), std::string::npos);
}

}  // namespace
}  // namespace metronome::play
