#include "learner/sac/replay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include "learner/sac/draw_batch.h"
#include "learner/sac/sac_state.h"
#include "learner/sac/transition.h"
#include "tests/unit/support/synthetic_run.h"

namespace metronome::sac {
namespace {

using testing::SmallSacConfig;
using testing::SyntheticEpisode;

/// Episodes 0 to count - 1 of 40 steps, three heads of 14, 13 and 13.
Replay Filled(const RunConfig& config, std::uint64_t count) {
  Replay replay(config);
  const PolicySnapshot snapshot = SnapshotOf(InitialSacState(config), config);
  for (std::uint64_t i = 0; i < count; ++i) replay.Add(SyntheticEpisode(config, snapshot, i));
  return replay;
}

void EndAfter(std::size_t steps, StepFlag end, Episode& episode) {
  episode.observation.resize((steps + 1) * test::kObservationSize);
  episode.action.resize(steps * test::kActionSize);
  for (auto* numbers : {&episode.log_prob, &episode.reward}) numbers->resize(steps);
  episode.head.resize(steps);
  episode.flags.resize(steps);
  episode.flags.back() = end;
}

TEST(ReplayTest, KeepsTheNewestWholeEpisodesThatFit) {
  RunConfig config = SmallSacConfig();
  config.mutable_sac()->set_replay_steps(130);
  const Replay replay = Filled(config, 7);
  EXPECT_EQ(replay.steps(), 120U);
  ASSERT_EQ(replay.episodes(), 3U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(replay.episode(i).episode.number, 4 + i);
  EXPECT_EQ(replay.StepsOf(0), 3 * 14U);
  EXPECT_EQ(replay.StepsOf(1), 3 * 13U);
  EXPECT_EQ(replay.StepOf(0, 0).of->episode.number, 4U);
  EXPECT_EQ(replay.StepOf(2, 38).of->episode.number, 6U);
  EXPECT_EQ(replay.StepOf(2, 38).t, 39);
  // Of episodes 4 to 6 the last alone has success.
  EXPECT_EQ(replay.SuccessStepsOf(1), 13U);
  EXPECT_EQ(replay.SuccessStepOf(1, 0).of->episode.number, 6U);
  EXPECT_EQ(replay.SuccessStepOf(1, 12).t, 26);
}

TEST(ReplayTest, RanksTheEpisodesOfATaskByTheirReward) {
  RunConfig config = SmallSacConfig();
  config.mutable_sac()->set_replay_steps(200);
  const Replay replay = Filled(config, 9);  // 4 to 8 are left
  ASSERT_EQ(replay.EpisodesOf(0), 5U);
  std::set<std::uint64_t> numbers;
  double least = replay.BestOf(0, 0).total_reward;
  for (std::size_t rank = 0; rank < 5; ++rank) {
    const ReplayEpisode& episode = replay.BestOf(0, rank);
    const std::vector<float>& reward = episode.episode.reward;
    EXPECT_EQ(episode.total_reward, std::accumulate(reward.begin(), reward.end(), 0.0));
    EXPECT_LE(episode.total_reward, least);
    least = episode.total_reward;
    numbers.insert(episode.episode.number);
  }
  EXPECT_EQ(numbers, (std::set<std::uint64_t>{4, 5, 6, 7, 8}));
}

TEST(ReplayTest, FindsEachStepOfAHeadOnce) {
  const Replay replay = Filled(SmallSacConfig(), 5);
  for (std::int32_t head = 0; head < 3; ++head) {
    std::set<std::pair<std::uint64_t, std::int32_t>> found;
    for (std::size_t i = 0; i < replay.StepsOf(head); ++i) {
      const ReplayStep step = replay.StepOf(head, i);
      EXPECT_EQ(step.t * 3 / 40, head);
      found.emplace(step.of->episode.number, step.t);
    }
    EXPECT_EQ(found.size(), replay.StepsOf(head));
  }
}

TEST(ReplayTest, LearnsFromTheRewardThatIsAskedFor) {
  RunConfig config = SmallSacConfig();
  const float official = Filled(config, 1).episode(0).episode.reward[5];
  config.mutable_environment()->set_reward(REWARD_SUCCESS);
  config.mutable_environment()->set_success_reward(12);
  EXPECT_EQ(Filled(config, 1).episode(0).episode.reward[5], official + 12);
}

TEST(TransitionTest, SumsTheRewardsOfNStepsAndIsValuedByTheHeadThatActsThere) {
  RunConfig config = SmallSacConfig();
  config.mutable_sac()->set_n_step(3);
  config.mutable_sac()->set_discount(0.5);
  const Replay replay = Filled(config, 1);
  const std::vector<float>& reward = replay.episode(0).episode.reward;
  const Transition inside = TransitionAt(replay.StepOf(0, 2), config.sac());
  EXPECT_EQ(inside.head, 0);
  EXPECT_FLOAT_EQ(inside.reward, reward[2] + 0.5F * reward[3] + 0.25F * reward[4]);
  EXPECT_EQ(inside.next_t, 5);
  EXPECT_EQ(inside.next_head, 0);
  EXPECT_EQ(inside.next_discount, 0.125F);
  const Transition across = TransitionAt(replay.StepOf(0, 12), config.sac());
  EXPECT_EQ(across.next_t, 15);
  EXPECT_EQ(across.next_head, 1);
}

TEST(TransitionTest, NothingComesAfterTheHorizonUnlessItIsAskedFor) {
  RunConfig config = SmallSacConfig();
  config.mutable_sac()->set_n_step(3);
  config.mutable_sac()->set_discount(0.5);
  for (const TimeLimitValue value : {ZERO, BOOTSTRAP}) {
    config.mutable_sac()->set_time_limit_value(value);
    const Replay replay = Filled(config, 1);
    const Transition last = TransitionAt(replay.StepOf(2, 12), config.sac());
    EXPECT_EQ(last.step.t, 39);
    EXPECT_FLOAT_EQ(last.reward, replay.episode(0).episode.reward[39]);
    EXPECT_EQ(last.next_t, 40);
    EXPECT_EQ(last.next_head, 2);
    EXPECT_EQ(last.next_discount, value == ZERO ? 0 : 0.5F);
    // The last that sees n steps: its state after them is the final one.
    const Transition third = TransitionAt(replay.StepOf(2, 10), config.sac());
    EXPECT_EQ(third.next_t, 40);
    EXPECT_EQ(third.next_discount, value == ZERO ? 0 : 0.125F);
    EXPECT_EQ(TransitionAt(replay.StepOf(2, 9), config.sac()).next_discount, 0.125F);
  }
}

TEST(TransitionTest, AnEpisodeThatEndsEarlyIsBootstrappedUnlessItTerminated) {
  RunConfig config = SmallSacConfig();
  config.mutable_environment()->mutable_spec()->set_may_end_early(true);
  const PolicySnapshot snapshot = SnapshotOf(InitialSacState(config), config);
  for (const StepFlag end : {kStepTerminated, kStepTruncated}) {
    Episode episode = SyntheticEpisode(config, snapshot, 0);
    EndAfter(20, end, episode);
    Replay replay(config);
    replay.Add(episode);
    const Transition last = TransitionAt(replay.StepOf(1, 5), config.sac());
    EXPECT_EQ(last.next_t, 20);
    EXPECT_EQ(last.next_head, 1);  // that would have acted
    EXPECT_EQ(last.next_discount > 0, end == kStepTruncated);
  }
}

TEST(DrawBatchTest, HasEquallyManySamplesOfEachHeadSortedAndDependsOnTheGradientStepAlone) {
  const RunConfig config = SmallSacConfig();
  const Replay replay = Filled(config, 9);
  std::map<std::int32_t, int> of_head;
  const std::vector<Transition> batch = DrawBatch(replay, config, 4);
  ASSERT_EQ(batch.size(), 60U);
  for (std::size_t i = 0; i < batch.size(); ++i) {
    ++of_head[batch[i].head];
    if (i == 0) continue;
    EXPECT_LE(std::pair(batch[i - 1].head, batch[i - 1].next_head),
              std::pair(batch[i].head, batch[i].next_head));
  }
  EXPECT_EQ(of_head, (std::map<std::int32_t, int>{{0, 20}, {1, 20}, {2, 20}}));
  const auto places = [](const std::vector<Transition>& of) {
    std::vector<std::pair<std::uint64_t, std::int32_t>> all;
    for (const Transition& each : of) all.emplace_back(each.step.of->episode.number, each.step.t);
    return all;
  };
  EXPECT_EQ(places(DrawBatch(replay, config, 4)), places(batch));
  EXPECT_NE(places(DrawBatch(replay, config, 5)), places(batch));
}

TEST(DrawBatchTest, HasItsShareOfEpisodesWithSuccess) {
  RunConfig config = SmallSacConfig();
  config.mutable_sac()->set_best_share(0);
  const Replay replay = Filled(config, 9);  // a third of the episodes have success
  const auto of_success = [&](double share) {
    config.mutable_sac()->set_success_share(share);
    std::map<std::int32_t, int> of_head;
    for (const Transition& each : DrawBatch(replay, config, 4)) {
      of_head[each.head] += each.step.of->success ? 1 : 0;
    }
    return of_head;
  };
  EXPECT_EQ(of_success(1), (std::map<std::int32_t, int>{{0, 20}, {1, 20}, {2, 20}}));
  for (const auto& [head, samples] : of_success(0.8)) EXPECT_GE(samples, 16) << head;
  // There are more of them than is asked for.
  EXPECT_EQ(of_success(0.33), of_success(0));
}

TEST(DrawBatchTest, DrawsAShareByTheRankOfTheReward) {
  RunConfig config = SmallSacConfig();
  config.mutable_sac()->set_success_share(0);
  config.mutable_sac()->set_best_share(0.3);
  const Replay replay = Filled(config, 9);
  std::map<const ReplayEpisode*, int> drawn;
  std::map<std::int32_t, int> of_head;
  constexpr int kBatches = 2000;
  for (std::uint64_t step = 0; step < kBatches; ++step) {
    for (const Transition& each : DrawBatch(replay, config, step)) {
      ++drawn[each.step.of];
      ++of_head[each.step.of->episode.head[std::size_t(each.step.t)]];
    }
  }
  constexpr double kSamples = 60.0 * kBatches;
  for (std::size_t rank = 0; rank < 9; ++rank) {
    const double by_rank = std::log(1 + 1 / double(rank + 1)) / std::log(10);
    const double expected = kSamples * (0.7 / 9 + 0.3 * by_rank);
    EXPECT_NEAR(drawn[&replay.BestOf(0, rank)], expected, 5 * std::sqrt(expected)) << rank;
  }
  EXPECT_EQ(of_head, (std::map<std::int32_t, int>{
                         {0, 20 * kBatches}, {1, 20 * kBatches}, {2, 20 * kBatches}}));
}

TEST(DrawBatchTest, EachTaskHasItsOwnBestEpisodes) {
  RunConfig config = SmallSacConfig();
  for (const char* task : {"a", "b", "c"}) {
    config.mutable_environment()->mutable_spec()->add_tasks(task);
  }
  config.mutable_sac()->set_success_share(0);
  config.mutable_sac()->set_best_share(1);
  const Replay replay = Filled(config, 9);
  std::map<const ReplayEpisode*, int> drawn;
  std::set<std::int32_t> steps_of_best;
  constexpr int kBatches = 500;
  for (std::uint64_t step = 0; step < kBatches; ++step) {
    for (const Transition& each : DrawBatch(replay, config, step)) {
      ++drawn[each.step.of];
      if (each.step.of == &replay.BestOf(0, 0)) steps_of_best.insert(each.step.t);
    }
  }
  for (std::size_t task = 0; task < 3; ++task) {
    for (std::size_t rank = 0; rank < 3; ++rank) {
      const ReplayEpisode& episode = replay.BestOf(task, rank);
      EXPECT_EQ(episode.episode.number % 3, task);
      const double expected =
          60.0 * kBatches / 3 * std::log(1 + 1 / double(rank + 1)) / std::log(4);
      EXPECT_NEAR(drawn[&episode], expected, 5 * std::sqrt(expected)) << task << " " << rank;
    }
  }
  EXPECT_EQ(steps_of_best.size(), 40U);
}

TEST(DrawBatchTest, AHeadThatTheBestEpisodeDidNotReachLearnsFromOthers) {
  RunConfig config = SmallSacConfig();
  config.mutable_environment()->mutable_spec()->set_may_end_early(true);
  config.mutable_sac()->set_best_share(1);
  config.mutable_sac()->set_success_share(0);
  const PolicySnapshot snapshot = SnapshotOf(InitialSacState(config), config);
  Replay replay(config);
  for (std::uint64_t number = 0; number < 2; ++number) {
    Episode episode = SyntheticEpisode(config, snapshot, number);
    if (number == 1) EndAfter(20, kStepTerminated, episode);
    std::fill(episode.reward.begin(), episode.reward.end(), number == 0 ? 0.0F : 100.0F);
    replay.Add(episode);
  }
  for (const Transition& each : DrawBatch(replay, config, 0)) {
    EXPECT_TRUE(each.head < 2 || each.step.of->episode.number == 0) << each.head;
  }
}

}  // namespace
}  // namespace metronome::sac
