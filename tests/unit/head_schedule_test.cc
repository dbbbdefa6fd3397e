#include "common/head_schedule.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <utility>
#include <vector>

namespace metronome {
namespace {

TEST(HeadScheduleTest, SegmentsAreOrderedCompleteAndBalanced) {
  for (const auto& [k, horizon] :
       std::vector<std::pair<int, int>>{{1, 500}, {3, 500}, {10, 500}, {7, 150}, {5, 5}}) {
    const HeadSchedule schedule(k, horizon);
    std::vector<int> steps(k, 0);
    for (int t = 0, last = 0; t < horizon; last = schedule.HeadAt(t++)) {
      EXPECT_GE(schedule.HeadAt(t), last);
      ++steps.at(schedule.HeadAt(t));
    }
    const auto [low, high] = std::minmax_element(steps.begin(), steps.end());
    EXPECT_LE(*high - *low, 1) << "k=" << k << " T=" << horizon;
    EXPECT_GE(*low, 1);
  }
}

TEST(HeadScheduleTest, BoundaryIsExactWhereAPrecomputedRatioRoundsDown) {
  EXPECT_EQ(HeadSchedule(2, 98).HeadAt(49), 1);
  EXPECT_EQ(HeadSchedule(2, 98).HeadAt(48), 0);
}

TEST(HeadScheduleTest, ThePapersExampleGivesFiveStepsToEachOfTwentyHeads) {
  const HeadSchedule schedule(20, 100);  // the paper's t = 1..5 are steps 0..4 here
  for (int t = 0; t < 100; ++t) EXPECT_EQ(schedule.HeadAt(t), t / 5);
}

TEST(HeadScheduleTest, TheValueAfterTheLastStepBelongsToTheLastHead) {
  const HeadSchedule schedule(10, 500);
  EXPECT_EQ(schedule.ValueHeadAt(500), 9);
  EXPECT_EQ(schedule.ValueHeadAt(0), 0);
  EXPECT_THROW((void)schedule.ValueHeadAt(501), std::out_of_range);
}

TEST(HeadScheduleTest, RefusesHeadsAndStepsOutsideTheirRange) {
  EXPECT_THROW(HeadSchedule(0, 10), std::invalid_argument);
  EXPECT_THROW(HeadSchedule(11, 10), std::invalid_argument);
  EXPECT_THROW(HeadSchedule(1, 0), std::invalid_argument);
  EXPECT_THROW((void)HeadSchedule(2, 10).HeadAt(-1), std::out_of_range);
  EXPECT_THROW((void)HeadSchedule(2, 10).HeadAt(10), std::out_of_range);
}

}  // namespace
}  // namespace metronome
