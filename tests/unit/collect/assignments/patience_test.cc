#include "learner/collect/assignments/patience.h"

#include <gtest/gtest.h>

#include "learner/collect/assignments/idle_time.h"

namespace metronome::collect::assignments {
namespace {

using std::chrono::milliseconds;

TEST(PatienceTest, LateIsThreeMediansAndLostNineDoubledWithEachFurtherTry) {
  Patience patience{AssignmentRules()};
  EXPECT_EQ(patience.Late(), milliseconds(6000)) << "before anything was measured";
  for (const int ms : {300, 400, 5000}) patience.Learn(milliseconds(ms));
  EXPECT_EQ(patience.Late(), milliseconds(1200));
  EXPECT_EQ(patience.Lost(1), milliseconds(3600));
  EXPECT_EQ(patience.Lost(3), milliseconds(14400));
  EXPECT_EQ(patience.Lost(7), patience.Lost(100));
}

TEST(PatienceTest, ShortLatenessIsNoise) {
  Patience patience{AssignmentRules()};
  patience.Learn(milliseconds(1));
  EXPECT_EQ(patience.Late(), milliseconds(250));
  EXPECT_EQ(patience.Lost(1), milliseconds(750));
}

TEST(IdleTimeTest, TheShareIsOfTheTimeBetweenCalls) {
  IdleTime idle;
  const IdleTime::TimePoint begin;
  idle.Count(2, 2, begin);
  idle.Count(2, 1, begin + milliseconds(300));
  idle.Count(2, 2, begin + milliseconds(400));
  EXPECT_DOUBLE_EQ(idle.TakeShare(), 500.0 / 800.0);
  EXPECT_EQ(idle.TakeShare(), 0);
}

}  // namespace
}  // namespace metronome::collect::assignments
