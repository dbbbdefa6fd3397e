#include "common/policy/head_schedule.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/unit/support/environments.h"

namespace metronome::policy {
namespace {

using Heads = std::vector<std::int32_t>;

RunConfig Config(Schedule schedule, int heads, int horizon, std::uint64_t seed = 1) {
  RunConfig config;
  config.set_seed(seed);
  config.mutable_environment()->set_horizon(horizon);
  config.mutable_policy()->set_heads(heads);
  config.mutable_policy()->set_schedule(schedule);
  return config;
}

HeadSchedule Of(Schedule schedule, int heads, int horizon, std::uint64_t number = 0) {
  const RunConfig config = Config(schedule, heads, horizon);
  return HeadSchedule::OfTraining(config, number);
}

Heads AllOf(const HeadSchedule& schedule) {
  Heads heads;
  for (int t = 0; t < schedule.horizon(); ++t) heads.push_back(schedule.HeadAt(t));
  return heads;
}

/// The heads in the order in which they act, each block once.
Heads OrderOf(const HeadSchedule& schedule) {
  Heads order = AllOf(schedule);
  order.erase(std::unique(order.begin(), order.end()), order.end());
  return order;
}

Heads Shuffled(std::uint64_t seed, std::uint64_t number,
               numbers::RandomPurpose purpose = numbers::RandomPurpose::kTrain, int heads = 10) {
  return OrderOf({Config(SCHEDULE_SHUFFLED, heads, 500, seed), {purpose, seed, number}, 0});
}

const std::vector<std::pair<int, int>> kShapes = {{1, 500},  {2, 500},  {3, 500},  {5, 500},
                                                  {10, 500}, {20, 500}, {50, 500}, {20, 100},
                                                  {7, 150},  {5, 5},    {3, 40},   {1, 1}};

class EveryScheduleTest : public ::testing::TestWithParam<Schedule> {};

TEST_P(EveryScheduleTest, StepsAreSharedOutEquallyToOneStep) {
  for (const auto& [k, horizon] : kShapes) {
    for (const std::uint64_t number : {0, 1, 99}) {
      std::vector<int> steps(k, 0);
      for (const auto head : AllOf(Of(GetParam(), k, horizon, number))) ++steps.at(head);
      const auto [low, high] = std::minmax_element(steps.begin(), steps.end());
      EXPECT_LE(*high - *low, 1) << "k=" << k << " T=" << horizon;
      EXPECT_GE(*low, 1);
    }
  }
}

TEST_P(EveryScheduleTest, TheValueAfterTheLastStepBelongsToTheHeadThatActedInIt) {
  for (const auto& [k, horizon] : kShapes) {
    const HeadSchedule schedule = Of(GetParam(), k, horizon);
    for (int t = 0; t < horizon; ++t) EXPECT_EQ(schedule.ValueHeadAt(t), schedule.HeadAt(t));
    EXPECT_EQ(schedule.ValueHeadAt(horizon), schedule.HeadAt(horizon - 1));
    EXPECT_THROW((void)schedule.ValueHeadAt(horizon + 1), std::out_of_range);
  }
}

TEST_P(EveryScheduleTest, TheOrderOfQueriesAndOtherEpisodesBetweenThemDoNotEnter) {
  const HeadSchedule schedule = Of(GetParam(), 7, 150, 3);
  const Heads forward = AllOf(schedule);
  for (int t = 149; t >= 0; --t) {
    const HeadSchedule other = Of(GetParam(), 7, 150, std::uint64_t(t));
    (void)other.HeadAt(t);
    EXPECT_EQ(schedule.HeadAt(t), forward[t]);
    EXPECT_EQ(Of(GetParam(), 7, 150, 3).HeadAt(t), forward[t]);
  }
}

TEST_P(EveryScheduleTest, OneHeadHasAllSteps) {
  EXPECT_EQ(AllOf(Of(GetParam(), 1, 40, 5)), Heads(40, 0));
}

TEST_P(EveryScheduleTest, RefusesHeadsAndStepsOutsideTheirRange) {
  EXPECT_THROW(Of(GetParam(), 0, 10), std::invalid_argument);
  EXPECT_THROW(Of(GetParam(), 11, 10), std::invalid_argument);
  EXPECT_THROW(Of(GetParam(), 1, 0), std::invalid_argument);
  EXPECT_THROW((void)Of(GetParam(), 2, 10).HeadAt(-1), std::out_of_range);
  EXPECT_THROW((void)Of(GetParam(), 2, 10).HeadAt(10), std::out_of_range);
}

INSTANTIATE_TEST_SUITE_P(Schedules, EveryScheduleTest,
                         ::testing::Values(SCHEDULE_BLOCKS, SCHEDULE_INTERLEAVED,
                                           SCHEDULE_SHUFFLED));

TEST(BlocksTest, AreInOrderAndTheSameInEveryEpisode) {
  for (const auto& [k, horizon] : kShapes) {
    const Heads heads = AllOf(Of(SCHEDULE_BLOCKS, k, horizon));
    EXPECT_TRUE(std::is_sorted(heads.begin(), heads.end()));
    EXPECT_EQ(AllOf(Of(SCHEDULE_BLOCKS, k, horizon, 7)), heads);
    EXPECT_EQ(Of(SCHEDULE_BLOCKS, k, horizon).ValueHeadAt(horizon), k - 1);
  }
}

TEST(BlocksTest, AreTheDefault) { EXPECT_EQ(RunConfig().policy().schedule(), SCHEDULE_BLOCKS); }

TEST(BlocksTest, TheBoundaryIsExactWhereAPrecomputedRatioRoundsDown) {
  EXPECT_EQ(Of(SCHEDULE_BLOCKS, 2, 98).HeadAt(49), 1);
  EXPECT_EQ(Of(SCHEDULE_BLOCKS, 2, 98).HeadAt(48), 0);
}

TEST(BlocksTest, ThePapersExampleGivesFiveStepsToEachOfTwentyHeads) {
  const HeadSchedule schedule = Of(SCHEDULE_BLOCKS, 20, 100);  // its t = 1..5 are steps 0..4 here
  for (int t = 0; t < 100; ++t) EXPECT_EQ(schedule.HeadAt(t), t / 5);
}

TEST(InterleavedTest, HeadsTakeTurnsFromStepToStepInEveryEpisode) {
  EXPECT_EQ(AllOf(Of(SCHEDULE_INTERLEAVED, 3, 8)), (Heads{0, 1, 2, 0, 1, 2, 0, 1}));
  EXPECT_EQ(AllOf(Of(SCHEDULE_INTERLEAVED, 3, 8, 9)), (Heads{0, 1, 2, 0, 1, 2, 0, 1}));
  EXPECT_EQ(Of(SCHEDULE_INTERLEAVED, 3, 8).ValueHeadAt(8), 1);
  EXPECT_EQ(Of(SCHEDULE_INTERLEAVED, 10, 500).ValueHeadAt(500), 9);
}

TEST(ShuffledTest, KeepsTheBlocksAndPermutesTheirHeads) {
  for (const auto& [k, horizon] : kShapes) {
    const HeadSchedule blocks = Of(SCHEDULE_BLOCKS, k, horizon);
    for (std::uint64_t number = 0; number < 20; ++number) {
      const HeadSchedule shuffled = Of(SCHEDULE_SHUFFLED, k, horizon, number);
      Heads order = OrderOf(shuffled);
      ASSERT_EQ(order.size(), std::size_t(k)) << "a block is torn, or a head comes twice";
      for (int t = 0; t < horizon; ++t) {
        ASSERT_EQ(shuffled.HeadAt(t), order[blocks.HeadAt(t)]) << "k=" << k << " t=" << t;
      }
      std::sort(order.begin(), order.end());
      for (int head = 0; head < k; ++head) ASSERT_EQ(order[head], head);
    }
  }
}

// Computed apart from this code, by a Philox4x64-10 and a Fisher-Yates shuffle written in Python
// from their papers, which give Random123's known answers.
TEST(ShuffledTest, ThePermutationsAreFrozen) {
  EXPECT_EQ(Shuffled(1, 0), (Heads{9, 1, 8, 2, 6, 7, 0, 5, 3, 4}));
  EXPECT_EQ(Shuffled(1, 1), (Heads{5, 4, 3, 0, 6, 2, 1, 8, 9, 7}));
  EXPECT_EQ(Shuffled(7, 12345678901234), (Heads{2, 7, 1, 0, 9, 6, 4, 3, 5, 8}));
  EXPECT_EQ(Shuffled(1, 0, numbers::RandomPurpose::kTrain, 5), (Heads{2, 3, 0, 1, 4}));
  EXPECT_EQ(Shuffled(1, 0, numbers::RandomPurpose::kEvaluate),
            (Heads{9, 7, 6, 5, 2, 4, 1, 3, 8, 0}));
}

TEST(ShuffledTest, NumberSeedAndPurposeOfTheEpisodeChangeThePermutationAndNothingElseDoes) {
  std::set<Heads> permutations;
  for (const auto purpose : {numbers::RandomPurpose::kTrain, numbers::RandomPurpose::kEvaluate}) {
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      for (std::uint64_t number = 0; number < 50; ++number) {
        permutations.insert(Shuffled(seed, number, purpose));
      }
    }
  }
  EXPECT_EQ(permutations.size(), 2U * 5U * 50U);
  RunConfig config = Config(SCHEDULE_SHUFFLED, 10, 500);
  test::SetTask(config, "box-close");
  config.mutable_policy()->set_critic_heads(CRITIC_HEADS_SHARED);
  config.mutable_ppo()->set_learning_rate(1);
  config.mutable_runtime()->set_domain(7);
  config.set_total_steps(1);
  EXPECT_EQ(OrderOf(HeadSchedule::OfTraining(config, 1)), Shuffled(1, 1));
  // Another horizon: other blocks, the same order.
  EXPECT_EQ(OrderOf(Of(SCHEDULE_SHUFFLED, 10, 100, 1)), Shuffled(1, 1));
}

TEST(ShuffledTest, EveryHeadIsAsLikelyInEveryBlock) {
  constexpr int kEpisodes = 10000;
  std::vector<std::vector<int>> counts(5, std::vector<int>(5, 0));
  for (std::uint64_t number = 0; number < kEpisodes; ++number) {
    const HeadSchedule schedule = Of(SCHEDULE_SHUFFLED, 5, 5, number);
    for (int block = 0; block < 5; ++block) ++counts[block][schedule.HeadAt(block)];
  }
  // Five standard deviations of a binomial count with p = 1/5: 5 * 40.
  for (const auto& of_block : counts) {
    for (const int count : of_block) EXPECT_LE(std::abs(count - kEpisodes / 5), 200);
  }
}

TEST(GivenOrderTest, GivesEachBlockItsHead) {
  const RunConfig config = Config(SCHEDULE_BLOCKS, 3, 7);  // blocks of 3, 2 and 2 steps
  EXPECT_EQ(AllOf({config, {2, 0, 2}, 0}), (Heads{2, 2, 2, 0, 0, 2, 2}));
  EXPECT_EQ(AllOf({config, {0, 1, 2}, 0}), AllOf(Of(SCHEDULE_BLOCKS, 3, 7)));
}

TEST(GivenOrderTest, IsRefusedWhereItDoesNotFit) {
  const auto refusal = [](Schedule schedule, std::vector<std::uint32_t> order) -> std::string {
    try {
      const HeadSchedule made(Config(schedule, 3, 7), std::move(order), 0);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "taken";
  };
  EXPECT_EQ(refusal(SCHEDULE_BLOCKS, {0, 1, 2}), "taken");
  EXPECT_EQ(refusal(SCHEDULE_SHUFFLED, {0, 1, 2}), "taken");
  EXPECT_EQ(refusal(SCHEDULE_BLOCKS, {0, 1}), "2 heads for the policy's 3 blocks of time");
  EXPECT_EQ(refusal(SCHEDULE_BLOCKS, {0, 3, 1}), "no head 3: the policy has 0 to 2");
  EXPECT_NE(refusal(SCHEDULE_INTERLEAVED, {0, 1, 2}).find("interleaved"), std::string::npos);
}

}  // namespace
}  // namespace metronome::policy
