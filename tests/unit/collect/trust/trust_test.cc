#include "learner/collect/trust/trust.h"

#include <gtest/gtest.h>

namespace metronome::collect::trust {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

Trust::TimePoint At(int ms) { return Trust::TimePoint{} + milliseconds(ms); }

TEST(TrustTest, WhoGivesUpAssignmentsRestsEverLongerUntilItBringsSomething) {
  Trust trust({}, {});
  trust.Join(1, "a", At(0));
  trust.GaveUp(1, At(0));
  EXPECT_FALSE(trust.StateOf(1, At(999)).reliable());
  EXPECT_EQ(trust.NextDeadline(At(0)), At(1000));
  EXPECT_TRUE(trust.StateOf(1, At(1000)).reliable());
  EXPECT_TRUE(trust.StateOf(1, At(1000)).silent);
  trust.GaveUp(1, At(1000));
  EXPECT_TRUE(trust.StateOf(1, At(2999)).rests);
  trust.Brought(1);
  EXPECT_TRUE(trust.StateOf(1, At(1001)).reliable());
  EXPECT_FALSE(trust.StateOf(1, At(1001)).silent);
}

TEST(TrustTest, BadAnswersInARowAreTooManyAndAGoodOneForgives) {
  TrustRules rules;
  rules.bad_answers_allowed = 2;
  Trust trust(rules, {});
  trust.Join(1, "a", At(0));
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(trust.Checked(1, false));
    EXPECT_TRUE(trust.Checked(1, false));
    EXPECT_TRUE(trust.Checked(1, true));
  }
  EXPECT_TRUE(trust.Checked(1, false));
  EXPECT_TRUE(trust.Checked(1, false));
  EXPECT_FALSE(trust.Checked(1, false));
  EXPECT_TRUE(trust.Checked(2, false)) << "of a stranger nothing is kept";
}

TEST(TrustTest, OfTooManyRefusedActorsTheOneRefusedLongestAgoIsForgotten) {
  TrustRules rules;
  rules.refused = 3;
  Trust trust(rules, {});
  for (std::uint64_t id = 1; id <= 4; ++id) trust.Refuse(id, "reason " + std::to_string(id));
  EXPECT_EQ(trust.RefusalOf(1), nullptr);
  for (std::uint64_t id = 2; id <= 4; ++id) {
    ASSERT_NE(trust.RefusalOf(id), nullptr);
    EXPECT_EQ(*trust.RefusalOf(id), "reason " + std::to_string(id));
  }
}

TEST(TrustTest, AnExclusionIsForGoodAndThereFromTheStart) {
  Trust trust({}, {{"a", "before"}});
  EXPECT_EQ(*trust.ExclusionOf("a"), "before");
  EXPECT_FALSE(trust.Exclude("a", "again"));
  EXPECT_TRUE(trust.Exclude("b", "now"));
  EXPECT_EQ(trust.excluded(), (ExcludedHosts{{"a", "before"}, {"b", "now"}}));
  EXPECT_EQ(trust.ExclusionOf("c"), nullptr);
}

TEST(TrustTest, AnActorThatIsGoneIsForgottenButNotItsHost) {
  TrustRules rules;
  rules.flaps.allowed = 0;
  Trust trust(rules, {});
  trust.Join(1, "a", At(0));
  trust.GaveUp(1, At(0));
  trust.Lose(1, At(10));
  EXPECT_TRUE(trust.StateOf(1, At(10)).reliable());
  EXPECT_EQ(trust.NextDeadline(At(10)), std::nullopt);
  EXPECT_EQ(trust.Join(2, "a", At(20)).flaps, 1U);
  EXPECT_TRUE(trust.StateOf(2, At(20)).on_probation);
}

}  // namespace
}  // namespace metronome::collect::trust
