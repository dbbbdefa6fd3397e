#include "learner/record/run_length.h"

#include <gtest/gtest.h>

namespace metronome::record {
namespace {

TEST(RunLengthTest, UpdatesAreKnownWhereEpisodesHaveOneLength) {
  const RunLength length{8000, 10, false};
  EXPECT_EQ(length.UpdatesAt(0, 0), 10U);
  EXPECT_EQ(length.UpdatesAt(4, 3200), 10U);
}

TEST(RunLengthTest, ElseTheyAreAsManyAsItTakesAtThePaceSoFar) {
  const RunLength length{8000, 10, true};
  EXPECT_EQ(length.UpdatesAt(0, 0), 10U) << "the fewest";
  EXPECT_EQ(length.UpdatesAt(4, 1000), 32U) << "250 steps an update";
  EXPECT_EQ(length.UpdatesAt(4, 999), 33U);
  EXPECT_EQ(length.UpdatesAt(30, 8000), 30U);
  EXPECT_EQ(length.UpdatesAt(30, 8100), 30U) << "the last one went beyond";
}

}  // namespace
}  // namespace metronome::record
