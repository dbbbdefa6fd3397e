#include "learner/collect/trust/flap_watch.h"

#include <gtest/gtest.h>

namespace metronome::collect::trust {
namespace {

using std::chrono::milliseconds;

FlapWatch::TimePoint At(int seconds) { return FlapWatch::TimePoint(std::chrono::seconds(seconds)); }

// An actor of `host` joins at `second` and is lost `stay` seconds later. @return its probation.
milliseconds Visit(FlapWatch& watch, std::uint64_t id, int second, int stay,
                   const std::string& host = "a") {
  const auto trusted = watch.Join(id, host, At(second));
  watch.Lose(id, At(second + stay));
  return std::chrono::duration_cast<milliseconds>(trusted - At(second));
}

TEST(FlapWatchTest, ProbationBeginsWithTheThirdFlapInARowAndDoublesUpToAMinute) {
  FlapWatch watch;
  std::vector<int> seconds;
  for (int i = 0; i < 11; ++i) {
    const auto probation = Visit(watch, std::uint64_t(i), 20 * i, 5);
    seconds.push_back(int(probation.count() / 1000));
  }
  EXPECT_EQ(seconds, (std::vector<int>{0, 0, 0, 1, 2, 4, 8, 16, 32, 60, 60}));
  EXPECT_EQ(watch.FlapsOf("a"), 11U);
}

TEST(FlapWatchTest, ALongStayForgives) {
  FlapWatch watch;
  for (int i = 0; i < 5; ++i) Visit(watch, std::uint64_t(i), 20 * i, 5);
  EXPECT_EQ(Visit(watch, 9, 200, 10), milliseconds(4000));
  EXPECT_EQ(Visit(watch, 10, 300, 5), milliseconds(0));
}

TEST(FlapWatchTest, OtherHostsAreNotBlamed) {
  FlapWatch watch;
  for (int i = 0; i < 5; ++i) Visit(watch, std::uint64_t(i), 20 * i, 5);
  EXPECT_EQ(Visit(watch, 9, 200, 5, "b"), milliseconds(0));
}

TEST(FlapWatchTest, AHostThatLosesAllItsActorsAtOnceHasFlappedOnce) {
  FlapWatch watch;
  for (std::uint64_t id = 0; id < 64; ++id) watch.Join(id, "a", At(0));
  for (std::uint64_t id = 0; id < 64; ++id) watch.Lose(id, At(5));
  EXPECT_EQ(watch.FlapsOf("a"), 1U);
}

TEST(FlapWatchTest, ToldAgainThatAnActorIsThereItsProbationDoesNotBeginAnew) {
  FlapWatch watch;
  for (int i = 0; i < 3; ++i) Visit(watch, std::uint64_t(i), 20 * i, 5);
  EXPECT_EQ(watch.Join(9, "a", At(100)), At(101));
  EXPECT_EQ(watch.Join(9, "a", At(150)), At(101));
}

TEST(FlapWatchTest, LosingWhoNeverJoinedIsNothing) {
  FlapWatch watch;
  watch.Lose(3, At(1));
  EXPECT_EQ(watch.FlapsOf("a"), 0U);
}

TEST(FlapWatchTest, OfTooManyFlappingHostsTheOneThatFlappedLongestAgoIsForgotten) {
  FlapRules rules;
  rules.hosts = 100;
  FlapWatch watch(rules);
  for (int i = 0; i < 101; ++i) {
    Visit(watch, std::uint64_t(i), 20 * i, 5, "host" + std::to_string(i));
    if (i == 50) Visit(watch, 1000, 20 * i + 10, 5, "host1");
  }
  EXPECT_EQ(watch.FlapsOf("host0"), 0U);
  EXPECT_EQ(watch.FlapsOf("host1"), 2U);
  EXPECT_EQ(watch.FlapsOf("host2"), 1U);
  Visit(watch, 2000, 9000, 5, "one more");
  EXPECT_EQ(watch.FlapsOf("host1"), 2U) << "it flapped later than others";
  EXPECT_EQ(watch.FlapsOf("host2"), 0U);
}

}  // namespace
}  // namespace metronome::collect::trust
