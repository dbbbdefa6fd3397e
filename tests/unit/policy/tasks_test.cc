#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/policy/head_schedule.h"
#include "common/policy/network.h"
#include "common/policy/network_input.h"
#include "common/policy/snapshot.h"
#include "common/policy/task_of.h"
#include "tests/unit/support/environments.h"

/// A run of several tasks.
namespace metronome::policy {
namespace {

constexpr int kHeads = 5;
constexpr int kHorizon = 20;

RunConfig Config(int tasks, HeadsBy by = HEADS_BY_TIME, int heads = kHeads) {
  RunConfig config;
  test::SetTask(config, "push");
  for (int i = 0; tasks > 1 && i < tasks; ++i)
    config.mutable_environment()->mutable_spec()->add_tasks("task" + std::to_string(i));
  config.mutable_environment()->set_horizon(kHorizon);
  config.mutable_policy()->set_heads(heads);
  config.mutable_policy()->set_heads_by(by);
  return config;
}

TEST(TaskOfTest, EachBatchHasEquallyManyEpisodesOfEachTask) {
  const RunConfig config = Config(3);
  for (std::uint64_t batch = 0; batch < 4; ++batch) {
    std::map<std::size_t, int> episodes;
    for (std::uint64_t i = 0; i < 12; ++i) ++episodes[TaskOf(config, batch * 12 + i)];
    EXPECT_EQ(episodes, (std::map<std::size_t, int>{{0, 4}, {1, 4}, {2, 4}}));
  }
  EXPECT_EQ(TaskOf(Config(1), 7), 0U);
}

TEST(TasksTest, HeadsByTaskAndTimeAreEachTasksOwnBlocks) {
  const RunConfig config = Config(3, HEADS_BY_TASK_TIME);
  const RunConfig alone = Config(1);
  for (std::uint64_t number = 0; number < 6; ++number) {
    const auto schedule = HeadSchedule::OfTraining(config, number);
    EXPECT_EQ(schedule.task(), number % 3);
    EXPECT_EQ(schedule.heads(), 3 * kHeads);
    for (int t = 0; t <= kHorizon; ++t) {
      const auto first = static_cast<std::int32_t>(number % 3) * kHeads;
      EXPECT_EQ(schedule.ValueHeadAt(t),
                first + HeadSchedule::OfTraining(alone, number).ValueHeadAt(t));
    }
  }
}

TEST(TasksTest, HeadsByTimeAreSharedAndHeadsByTaskActAtAllTimes) {
  const auto by_time = HeadSchedule::OfTraining(Config(3), 2);
  EXPECT_EQ(by_time.heads(), kHeads);
  EXPECT_EQ(by_time.HeadAt(kHorizon - 1), kHeads - 1);
  const auto by_task = HeadSchedule::OfTraining(Config(3, HEADS_BY_TASK, 1), 2);
  EXPECT_EQ(by_task.heads(), 3);
  for (int t = 0; t < kHorizon; ++t) EXPECT_EQ(by_task.HeadAt(t), 2);
}

TEST(TasksTest, ATaskThatTheRunDoesNotHaveIsRefused) {
  EXPECT_THROW(HeadSchedule(Config(3), numbers::EpisodeKey{}, 3), std::out_of_range);
}

TEST(TasksTest, TheInputIsNormalisedByTheTasksStatisticsAndNamesTheTask) {
  RunConfig config = Config(2);
  config.mutable_policy()->set_method(SINGLE_TIME);
  config.mutable_environment()->mutable_spec()->set_observation_size(2);
  const NetworkShape shape = ShapeOf(config);
  ASSERT_EQ(shape.input(), 2 + 2 + 1);
  const std::vector<float> mean = {1, 2, 10, 20}, inv_std = {1, 0.5F, 2, 0.25F};
  const std::vector<float> observation = {11, 22};
  std::vector<float> input(5, -9.0F);
  WriteInput(shape, {mean.data(), inv_std.data(), 100}, observation.data(), 0, 10, 20,
             input.data());
  EXPECT_EQ(input, (std::vector<float>{10, 10, 1, 0, 0}));
  WriteInput(shape, {mean.data(), inv_std.data(), 100}, observation.data(), 1, 20, 20,
             input.data());
  EXPECT_EQ(input, (std::vector<float>{2, 0.5F, 0, 1, 1}));
}

TEST(TasksTest, WithoutTheOnehotTheInputIsAsOfOneTask) {
  RunConfig config = Config(2);
  config.mutable_environment()->set_task_id(TASK_ID_NONE);
  EXPECT_EQ(ShapeOf(config).input(), ShapeOf(Config(1)).input());
  EXPECT_EQ(ShapeOf(config).statistics(), 2 * ShapeOf(Config(1)).statistics());
}

TEST(TasksTest, ASnapshotHasTheStatisticsOfEachTask) {
  RunConfig config = Config(2);
  config.mutable_policy()->add_hidden(3);
  config.mutable_environment()->mutable_spec()->set_observation_size(2);
  const std::vector<float> actor(ActorLayout(ShapeOf(config)).size, 0.5F);
  const std::vector<RunningStatistics> statistics = {{}, {{3, 4}, {40, 90}, 10}};
  const PolicySnapshot snapshot = MakeSnapshot(7, actor.data(), statistics, config);
  EXPECT_EQ(snapshot.observation_mean, (std::vector<float>{0, 0, 3, 4}));
  EXPECT_FLOAT_EQ(snapshot.observation_inv_std[0], 1);
  EXPECT_FLOAT_EQ(snapshot.observation_inv_std[2], 0.5F);
  EXPECT_FLOAT_EQ(snapshot.observation_inv_std[3], 1 / 3.0F);
  EXPECT_EQ(SnapshotDefect(snapshot, config), std::nullopt);
  PolicySnapshot of_one = snapshot;
  of_one.observation_mean.resize(2);
  EXPECT_NE(SnapshotDefect(of_one, config), std::nullopt);
}

}  // namespace
}  // namespace metronome::policy
