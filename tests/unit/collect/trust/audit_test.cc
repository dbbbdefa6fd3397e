#include "learner/collect/trust/audit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace metronome::collect::trust {
namespace {

using Names = std::vector<std::string>;

Audit::Opinion Says(std::uint64_t actor, const std::string& host, float reward,
                    std::uint64_t number = 7) {
  Episode episode;
  episode.number = number;
  episode.reward = {reward};
  return {actor, host, episode};
}

TEST(AuditTest, TheShareIsChosenByAKey) {
  const Audit none({0, 1}), some({0.25, 1}), others({0.25, 2}), all({1, 1});
  int chosen = 0, both = 0;
  for (std::uint64_t number = 0; number < 4000; ++number) {
    EXPECT_FALSE(none.IsChosen(number));
    EXPECT_TRUE(all.IsChosen(number));
    chosen += some.IsChosen(number) ? 1 : 0;
    both += some.IsChosen(number) && others.IsChosen(number) ? 1 : 0;
  }
  EXPECT_NEAR(chosen, 1000, 100);
  EXPECT_NEAR(both, 250, 60) << "the key does not matter";
}

TEST(AuditTest, TwoActorsThatAgreeSettleItWhereverTheyAre) {
  Audit audit({1, 1});
  EXPECT_FALSE(audit.Hear(Says(1, "a", 0.5F)).settled);
  EXPECT_TRUE(audit.IsPending(7));
  const auto verdict = audit.Hear(Says(2, "a", 0.5F));
  ASSERT_TRUE(verdict.settled);
  EXPECT_EQ(verdict.settled->actor_id, 1U);
  EXPECT_EQ(verdict.vouchers, Names{"a"});
  EXPECT_TRUE(verdict.guilty.empty());
  EXPECT_FALSE(audit.IsPending(7));
  EXPECT_EQ(audit.counts().agreed, 1U);
  EXPECT_EQ(audit.counts().disputes, 0U);
}

// In every assignment of arrival, and by one bit: 0 is not -0.
TEST(AuditTest, WhereHostsDifferTheOddOneIsGuilty) {
  for (int odd = 0; odd < 3; ++odd) {
    Audit audit({1, 1});
    Audit::Verdict verdict;
    for (int i = 0; i < 3; ++i) {
      EXPECT_FALSE(verdict.settled) << odd;
      const std::string host(1, static_cast<char>('a' + i));
      verdict = audit.Hear(Says(std::uint64_t(i), host, i == odd ? -0.0F : 0.0F));
      // The first two agree where the third is odd: then it is not heard.
      if (odd == 2 && i == 1) break;
      EXPECT_EQ(verdict.disputed, i == 1) << odd;
    }
    ASSERT_TRUE(verdict.settled) << odd;
    EXPECT_FALSE(std::signbit(verdict.settled->episode.reward[0])) << odd;
    const Names guilty = odd == 2 ? Names{} : Names{std::string(1, static_cast<char>('a' + odd))};
    EXPECT_EQ(verdict.guilty, guilty) << odd;
    EXPECT_EQ(verdict.vouchers.size(), 2U) << odd;
  }
}

TEST(AuditTest, AHostCannotOutvoteAnotherByMoreActors) {
  Audit audit({1, 1});
  audit.Hear(Says(1, "a", 0));
  audit.Hear(Says(2, "b", 1));
  const auto more = audit.Hear(Says(3, "b", 1));
  EXPECT_FALSE(more.settled);
  EXPECT_TRUE(more.disputed);
  const auto verdict = audit.Hear(Says(4, "c", 0));
  ASSERT_TRUE(verdict.settled);
  EXPECT_EQ(verdict.guilty, Names{"b"});
}

TEST(AuditTest, AHostThatDiffersFromItselfIsGuiltyAndUnheard) {
  Audit audit({1, 1});
  audit.Hear(Says(1, "a", 0));
  const auto verdict = audit.Hear(Says(2, "a", 1));
  EXPECT_EQ(verdict.guilty, Names{"a"});
  EXPECT_FALSE(verdict.settled);
  EXPECT_FALSE(verdict.disputed);
  EXPECT_FALSE(audit.IsPending(7));
}

TEST(AuditTest, ThreeAnswersNeedAFourth) {
  Audit audit({1, 1});
  audit.Hear(Says(1, "a", 0));
  audit.Hear(Says(2, "b", 1));
  EXPECT_TRUE(audit.Hear(Says(3, "c", 2)).disputed);
  const auto verdict = audit.Hear(Says(4, "d", 1));
  ASSERT_TRUE(verdict.settled);
  EXPECT_EQ(verdict.settled->actor_id, 2U);
  EXPECT_EQ(verdict.guilty, (Names{"a", "c"}));
  EXPECT_EQ(audit.counts().disputes, 1U);
}

TEST(AuditTest, AloneAnOpinionStandsUnlessItIsDisputed) {
  Audit audit({1, 1});
  EXPECT_THROW(audit.SettleAlone(7), std::logic_error);
  audit.Hear(Says(1, "a", 0));
  EXPECT_EQ(audit.SettleAlone(7).actor_id, 1U);
  EXPECT_EQ(audit.counts().alone, 1U);
  audit.Hear(Says(1, "a", 0));
  audit.Hear(Says(2, "b", 1));
  EXPECT_THROW(audit.SettleAlone(7), std::logic_error);
}

TEST(AuditTest, WhatAHostSaidIsForgottenWithIt) {
  Audit audit({1, 1});
  audit.Hear(Says(1, "a", 0, 7));
  audit.Hear(Says(1, "a", 0, 8));
  audit.Hear(Says(2, "b", 1, 8));
  EXPECT_EQ(audit.Forget("a"), std::vector<std::uint64_t>{7});
  EXPECT_EQ(audit.Pending(), std::vector<std::uint64_t>{8});
  EXPECT_FALSE(audit.IsDisputed(8));
}

TEST(AuditTest, WhatIsDoubtedIsForgottenOnceItIsLearntFrom) {
  Audit audit({1e-9, 1});
  for (std::uint64_t number = 0; number < 1000; ++number) audit.Choose(number);
  audit.Learnt(500);
  EXPECT_FALSE(audit.IsChosen(499));
  EXPECT_TRUE(audit.IsChosen(500));
}

}  // namespace
}  // namespace metronome::collect::trust
