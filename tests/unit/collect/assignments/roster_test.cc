#include "learner/collect/assignments/roster.h"

#include <gtest/gtest.h>

namespace metronome::collect::assignments {
namespace {

using std::chrono::milliseconds;

Roster::TimePoint At(int ms) { return Roster::TimePoint{} + milliseconds(ms); }

TEST(RosterTest, TheAssignmentThatWaitedLongestBeginsWhenAEnvIsFree) {
  Roster roster;
  roster.Join(1, "a", 1);
  roster.Give(1, 10, At(0));
  roster.Give(1, 11, At(0));
  EXPECT_EQ(roster.Release(1, 10, At(400)), milliseconds(400));
  EXPECT_EQ(roster.Release(1, 11, At(900)), milliseconds(500));
  EXPECT_EQ(roster.Release(1, 11, At(901)), std::nullopt);
}

TEST(RosterTest, WhatWasGivenUpStillTellsHowLongItTook) {
  Roster roster;
  roster.Join(1, "a", 2);
  roster.Give(1, 10, At(0));
  roster.Give(1, 11, At(50));
  const auto is_old = [](const Roster::Assignment& assignment) {
    return assignment.since < At(10);
  };
  const std::map<std::uint64_t, std::vector<std::uint64_t>> lost{{1, {10}}};
  EXPECT_EQ(roster.GiveUp(is_old), lost);
  EXPECT_EQ(roster.idle(), 1U);
  EXPECT_EQ(roster.Release(1, 10, At(5000)), milliseconds(5000));
}

TEST(RosterTest, TheLeastLoadedIsByAssignmentsAEnv) {
  Roster roster;
  roster.Join(1, "a", 1);
  roster.Join(2, "b", 4);
  roster.Give(1, 10, At(0));
  for (std::uint64_t number = 11; number < 14; ++number) roster.Give(2, number, At(0));
  const auto any = [](const auto&) { return std::size_t{8}; };
  EXPECT_EQ(roster.LeastLoaded(2, any), 2U);
  EXPECT_EQ(roster.LeastLoaded(2, [](const auto&) { return std::size_t{2}; }), 1U);
  EXPECT_EQ(roster.LeastLoaded(2, [](const auto&) { return std::size_t{0}; }), std::nullopt);
  EXPECT_EQ(roster.LeastLoaded(1, [](const auto&) { return std::size_t{2}; }), std::nullopt);
  EXPECT_EQ(roster.envs(), 5U);
  EXPECT_EQ(roster.Leave(2).size(), 3U);
}

}  // namespace
}  // namespace metronome::collect::assignments
