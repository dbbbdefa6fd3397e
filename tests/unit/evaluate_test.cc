#include "actor/evaluate.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdint>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "actor/metaworld/task_table.h"
#include "actor/rollout.h"
#include "common/config.h"
#include "common/head_schedule.h"
#include "common/network.h"
#include "common/random.h"

namespace metronome {
namespace {

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
  std::set<metaworld::RandVec> evaluation;
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    options.seed = seed;
    for (std::uint64_t i = 0; i < 50; ++i) {
      evaluation.insert(EvaluationPlacement(options, "push", i));
    }
  }
  EXPECT_EQ(evaluation.size(), 150U);
  RunConfig config;
  config.mutable_environment()->set_task("push");
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    config.set_seed(seed);
    for (std::uint64_t number = 0; number < 50; ++number) {
      EXPECT_EQ(evaluation.count(TrainingPlacement(config, number)), 0U);
    }
  }
}

TEST(TrainingPlacementTest, FixedIsOneForTheRunAndRandomOneForEachEpisode) {
  RunConfig config;
  config.mutable_environment()->set_task("box-close");
  EXPECT_NE(TrainingPlacement(config, 0), TrainingPlacement(config, 1));
  EXPECT_EQ(TrainingPlacement(config, 7), TrainingPlacement(config, 7));
  config.mutable_environment()->set_placements(PLACEMENTS_FIXED);
  EXPECT_EQ(TrainingPlacement(config, 0), TrainingPlacement(config, 1));
  const auto of_seed_one = TrainingPlacement(config, 0);
  config.set_seed(2);
  EXPECT_NE(TrainingPlacement(config, 0), of_seed_one);
}

/// Succeeds at the steps (counted from 1) that it is told to, and pays a reward of 1 a step.
class ScriptedEnvironment : public metaworld::Environment {
 public:
  explicit ScriptedEnvironment(std::set<int> successes) : successes_(std::move(successes)) {}
  metaworld::Observation Reset(const metaworld::RandVec& /*placement*/) override {
    step_ = 0;
    return {};
  }
  metaworld::StepResult Step(const metaworld::Action& /*action*/) override {
    ++step_;
    metaworld::StepResult result;
    result.reward = 1;
    result.info.success = successes_.count(step_) > 0;
    return result;
  }

 private:
  std::set<int> successes_;
  int step_ = 0;
};

EvaluatedEpisode PlayWithSuccessesAt(std::set<int> steps) {
  RunConfig given;
  given.mutable_environment()->set_task("push");
  given.mutable_environment()->set_horizon(20);
  const RunConfig config = Resolve(given);
  PolicySnapshot snapshot;
  snapshot.parameters.resize(ActorLayout(ShapeOf(config)).size);
  snapshot.observation_mean.resize(kObservationSize);
  snapshot.observation_inv_std.resize(kObservationSize);
  ScriptedEnvironment environment(std::move(steps));
  return PlayDeterministic(config, snapshot, EvaluationSchedule({}, config, 0), {}, environment);
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
}

/// Remembers the actions; the observation after t steps is t everywhere.
class RecordingEnvironment final : public metaworld::Environment {
 public:
  metaworld::Observation Reset(const metaworld::RandVec& /*placement*/) override {
    actions.clear();
    return {};
  }
  metaworld::StepResult Step(const metaworld::Action& action) override {
    actions.push_back(action);
    metaworld::StepResult result;
    result.observation.fill(double(actions.size()));
    return result;
  }

  std::vector<metaworld::Action> actions;
};

/// A policy whose action is its head: all weights are zero, head j's biases are j.
struct HeadsAsActions {
  explicit HeadsAsActions(Schedule schedule) {
    config.set_seed(3);
    config.mutable_environment()->set_task("push");
    config.mutable_environment()->set_horizon(40);
    config.mutable_policy()->set_heads(5);
    config.mutable_policy()->add_hidden(4);
    config.mutable_policy()->set_schedule(schedule);
    const MlpLayout layout = ActorLayout(ShapeOf(config));
    snapshot.parameters.assign(layout.size, 0.0F);
    for (std::size_t i = 0; i < 20; ++i) {
      const std::size_t head = i / 4;
      snapshot.parameters[layout.head.bias + i] = float(head);
      snapshot.parameters[layout.log_std + i] = -80;
    }
    snapshot.observation_mean.assign(kObservationSize, 0.0F);
    snapshot.observation_inv_std.assign(kObservationSize, 1.0F);
  }

  RunConfig config;
  PolicySnapshot snapshot;
};

std::vector<std::int32_t> HeadsOf(const RecordingEnvironment& environment) {
  std::vector<std::int32_t> heads;
  for (const metaworld::Action& action : environment.actions) {
    heads.push_back(static_cast<std::int32_t>(std::lround(action[0])));
  }
  return heads;
}

TEST(PlayDeterministicTest, HeadsFollowTheScheduleAndTheEvaluationsOwnOrders) {
  RecordingEnvironment environment;
  for (const Schedule schedule : {SCHEDULE_BLOCKS, SCHEDULE_INTERLEAVED, SCHEDULE_SHUFFLED}) {
    const HeadsAsActions policy(schedule);
    EvaluateOptions options;
    options.seed = 9;
    PlayDeterministic(policy.config, policy.snapshot, EvaluationSchedule(options, policy.config, 2),
                      {}, environment);
    const auto order = Permutation(5, {RandomPurpose::kHeadOrder, 9, 2, 2 /* kEvaluate */});
    const std::vector<std::int32_t> heads = HeadsOf(environment);
    ASSERT_EQ(heads.size(), 40U);
    for (std::int32_t t = 0; t < 40; ++t) {
      const std::int32_t block = t / 8;
      const std::int32_t want = schedule == SCHEDULE_BLOCKS        ? block
                                : schedule == SCHEDULE_INTERLEAVED ? t % 5
                                                                   : std::int32_t(order[block]);
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
    PlayDeterministic(policy.config, policy.snapshot, EvaluationSchedule(options, policy.config, 2),
                      {}, environment);
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
    const HeadSchedule heads(policy.config, {RandomPurpose::kTrain, 3, 17});
    for (std::int32_t t = 0; t < 40; ++t) {
      EXPECT_EQ(episode->head[t], heads.HeadAt(t));
      EXPECT_EQ(HeadsOf(environment)[t], heads.HeadAt(t));
    }
  }
}

TEST(RunEvaluateTest, NamesWhatIsWrongWithItsOptions) {
  const auto fail = [](const EvaluateOptions& options, int want) {
    std::ostringstream out;
    std::ostringstream err;
    EXPECT_EQ(RunEvaluate(options, out, err), want);
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
  EXPECT_NE(fail(options, 2).find("random, mt1"), std::string::npos);
}

}  // namespace
}  // namespace metronome
