#include "common/text/near_miss.h"

#include <gtest/gtest.h>

namespace metronome::text {
namespace {

const std::vector<std::string> kTasks = {"assembly", "bin-picking", "box-close", "push"};

TEST(NearMissTest, CountsInsertionsDeletionsSubstitutionsAndSwaps) {
  EXPECT_EQ(EditDistance("push", "push"), 0u);
  EXPECT_EQ(EditDistance("", "push"), 4u);
  EXPECT_EQ(EditDistance("psh", "push"), 1u);
  EXPECT_EQ(EditDistance("puush", "push"), 1u);
  EXPECT_EQ(EditDistance("bush", "push"), 1u);
  EXPECT_EQ(EditDistance("psuh", "push"), 1u);
  EXPECT_EQ(EditDistance("kitten", "sitting"), 3u);
}

TEST(NearMissTest, IgnoresCaseAndTakesUnderscoreForHyphen) {
  EXPECT_EQ(EditDistance("Bin_Picking", "bin-picking"), 0u);
}

TEST(NearMissTest, FindsTheNearestCandidate) {
  EXPECT_EQ(NearMiss("asembly", kTasks), "assembly");
  EXPECT_EQ(NearMiss("bin-piking", kTasks), "bin-picking");
  EXPECT_EQ(NearMiss("puhs", kTasks), "push");
}

TEST(NearMissTest, FindsTheOnlyCandidateThatANameIsPartOf) {
  EXPECT_EQ(NearMiss("box", kTasks), "box-close");
  EXPECT_EQ(NearMiss("push-the-cube-v3", kTasks), "push");
}

TEST(NearMissTest, StaysSilentWhenNothingIsNear) {
  EXPECT_EQ(NearMiss("drawer-open", kTasks), std::nullopt);
  EXPECT_EQ(NearMiss("", kTasks), std::nullopt);
}

TEST(NearMissTest, MessageNamesTheNearMissAndTheList) {
  EXPECT_EQ(UnknownName("task", "psh", kTasks),
            "unknown task \"psh\"; did you mean \"push\"? Known: assembly, bin-picking, box-close, "
            "push");
  EXPECT_EQ(UnknownName("task", "zzzzzzzz", {"push"}), "unknown task \"zzzzzzzz\". Known: push");
}

}  // namespace
}  // namespace metronome::text
