#include "learner/collect/assignments/number_book.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/unit/support/assignment_rules.h"

namespace metronome::collect::assignments {
namespace {

using test::Rules;
using Standing = NumberBook::Claim::Standing;

Standing StandingOf(const NumberBook& book, std::uint64_t number, std::uint64_t actor) {
  return book.ClaimOf(number, actor).standing;
}

TEST(NumberBookTest, StrangersCannotBringNumbers) {
  NumberBook book(Rules(4, 2));
  book.HandOut(0, {1, "a"});
  EXPECT_EQ(StandingOf(book, 0, 7), Standing::kNotAssigned);
  EXPECT_EQ(StandingOf(book, 0, 1), Standing::kWanted);
  EXPECT_EQ(StandingOf(book, 3, 1), Standing::kNotAssigned);
  EXPECT_EQ(StandingOf(book, 7, 1), Standing::kNotAssigned);
  EXPECT_EQ(StandingOf(book, ~std::uint64_t{0}, 1), Standing::kNotAssigned);
}

TEST(NumberBookTest, WhileANumberIsJudgedNobodyBringsItAndNobodyIsAsked) {
  NumberBook book(Rules(1, 1));
  book.HandOut(0, {1, "a"});
  book.Arrive(0);
  EXPECT_EQ(StandingOf(book, 0, 1), Standing::kNotAssigned);
  EXPECT_TRUE(book.open().empty());
  EXPECT_THROW(book.Arrive(0), std::logic_error);
  book.Accept(0, {"a"});
  EXPECT_EQ(StandingOf(book, 0, 7), Standing::kDuplicate);
  EXPECT_EQ(book.AcceptedOf(0), 1U);
  EXPECT_THROW(book.Accept(0, {"a"}), std::logic_error);
}

TEST(NumberBookTest, TheHostOfALostActorIsKnownWhileItMayBringANumber) {
  NumberBook book(Rules(1, 3, 1));
  book.HandOut(0, {1, "near"});
  book.HandOut(1, {1, "near"});
  book.Accept(0, {"near"});
  book.TakeBack(1, 1);
  book.Publish(1);
  EXPECT_EQ(StandingOf(book, 1, 1), Standing::kWanted);
  EXPECT_EQ(book.ClaimOf(1, 1).host, "near");
  EXPECT_EQ(book.ClaimOf(0, 1).host, "");
}

TEST(NumberBookTest, WhoBroughtANumberIsNotAskedAgainAndInADisputeNobodyOfItsHost) {
  NumberBook book(Rules(1, 1));
  book.HandOut(0, {1, "a"});
  book.Arrive(0);
  book.TakeBack(0, 1);
  book.AskAnother(0, {1, "a"}, false);
  EXPECT_EQ(StandingOf(book, 0, 1), Standing::kDuplicate);
  EXPECT_TRUE(book.open().empty());
  EXPECT_EQ(book.open_again().size(), 1U);
  EXPECT_FALSE(book.Find(0)->MayBePlayedBy(1, "a"));
  EXPECT_TRUE(book.Find(0)->MayBePlayedBy(2, "a"));
  book.AskAnother(0, {3, "b"}, true);
  EXPECT_FALSE(book.Find(0)->MayBePlayedBy(2, "a"));
  EXPECT_TRUE(book.Find(0)->MayBePlayedBy(4, "c"));
  book.Reopen(0);
  EXPECT_TRUE(book.Find(0)->MayBePlayedBy(1, "a"));
  EXPECT_EQ(book.open().size(), 1U);
  EXPECT_TRUE(book.open_again().empty());
}

TEST(NumberBookTest, WhatOnlyOneHostVouchesForIsFoundAndCanBeReopened) {
  NumberBook book(Rules(3, 1));
  book.Accept(0, {"a"});
  book.Accept(1, {"a", "b"});
  book.Accept(2, {"b"});
  EXPECT_EQ(book.OnTheWordOf("a"), std::vector<std::uint64_t>{0});
  book.Reopen(0);
  EXPECT_EQ(book.AcceptedOf(0), 2U);
  EXPECT_TRUE(book.open().contains(0));
}

// Actors that come, are asked, and go: the last are remembered, and whoever has it in hand.
TEST(NumberBookTest, OfThoseWhoWereAskedAndWentOnlySomeAreRemembered) {
  NumberBook book(Rules(1, 1));
  book.HandOut(0, {1, "holds"});
  for (std::uint64_t actor = 2; actor < 1000; ++actor) {
    book.HandOut(0, {actor, "goes"});
    book.TakeBack(0, actor);
  }
  EXPECT_EQ(book.Find(0)->asked.size(), NumberBook::kAskedKept);
  EXPECT_EQ(StandingOf(book, 0, 1), Standing::kWanted);
  EXPECT_EQ(StandingOf(book, 0, 2), Standing::kNotAssigned);
  EXPECT_EQ(StandingOf(book, 0, 999), Standing::kWanted);
}

TEST(NumberBookTest, BadRulesAreRefused) {
  AssignmentRules rules = Rules(0, 1);
  EXPECT_THROW(NumberBook{rules}, std::invalid_argument);
  rules = Rules(1, 1);
  rules.first_version = 2;
  EXPECT_THROW(NumberBook{rules}, std::invalid_argument);
}

}  // namespace
}  // namespace metronome::collect::assignments
