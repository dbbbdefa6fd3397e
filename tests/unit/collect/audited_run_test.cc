#include <gtest/gtest.h>

#include <map>
#include <set>

#include "common/process/exit_codes.h"
#include "learner/collect/trust/audit.h"
#include "tests/unit/support/fake_run.h"

/// Whole runs that are audited.
namespace metronome::collect {
namespace {

using testing::FakeActor;
using testing::FakeRun;
using testing::milliseconds;

std::vector<EpisodeMessage> Lie(const EpisodeMessage& truth) {
  EpisodeMessage lie = truth;
  lie.episode.reward[0] += 1;
  return {lie};
}

void ExpectAllTrue(const FakeRun& run, std::size_t numbers = 12) {
  ASSERT_EQ(run.learning.learnt.size(), numbers);
  for (std::size_t i = 0; i < numbers; ++i) {
    EXPECT_EQ(run.learning.learnt[i], i);
    EXPECT_EQ(run.learning.rewards[i], float(i)) << "a lie was learnt from";
  }
}

std::map<std::uint64_t, std::set<std::uint64_t>> ActorsByNumber(const FakeRun& run) {
  std::map<std::uint64_t, std::set<std::uint64_t>> actors;
  for (const EpisodeAssignment& assignment : run.bus.assignments) {
    for (const std::uint64_t number : assignment.numbers)
      actors[number].insert(assignment.actor_id);
  }
  return actors;
}

TEST(AuditedRunTest, EachEpisodeIsPlayedByTwoActorsAndLearntOnce) {
  FakeRun run;
  run.setup.audit = {1, 1};
  for (const std::uint64_t id : {1, 2, 3}) run.AddActor(id);
  EXPECT_EQ(run.Run(), process::kExitFinished);
  ExpectAllTrue(run);
  const auto actors = ActorsByNumber(run);
  EXPECT_EQ(actors.size(), 12U);
  for (const auto& [number, by] : actors) EXPECT_EQ(by.size(), 2U) << number;
}

TEST(AuditedRunTest, AnotherHostIsPreferredToAnotherActor) {
  FakeRun run;
  run.setup.audit = {1, 1};
  for (const std::uint64_t id : {1, 2, 3, 4}) {
    run.AddActor(id).status.vouched_host = id == 4 ? "far" : "near";
  }
  EXPECT_EQ(run.Run(), process::kExitFinished);
  for (const auto& [number, by] : ActorsByNumber(run)) EXPECT_TRUE(by.contains(4)) << number;
}

TEST(AuditedRunTest, ALoneActorIsBelievedAndARunGoesOnWhenTheOtherSaysNothing) {
  for (const bool second : {false, true}) {
    FakeRun run;
    run.setup.audit = {1, 1};
    run.AddActor(1);
    if (second)
      run.AddActor(2).answer = [](const EpisodeMessage&) { return std::vector<EpisodeMessage>{}; };
    EXPECT_EQ(run.Run(), process::kExitFinished);
    ExpectAllTrue(run);
    EXPECT_LT(run.bus.now() - Clock::time_point(std::chrono::hours(1)), std::chrono::seconds(40));
  }
}

TEST(AuditedRunTest, WhoComesWithinSecondsIsWaitedFor) {
  FakeRun run;
  run.setup.audit = {1, 1};
  run.AddActor(1).answer = Lie;
  for (const std::uint64_t id : {2, 3}) {
    FakeActor& late = run.AddActor(id);
    late.status.incarnation = 0;  // not yet
    ActorStatus comes = late.status;
    comes.incarnation = FakeRun::kIncarnation;
    run.bus.After(std::chrono::seconds(4), comes);
  }
  EXPECT_EQ(run.Run(), process::kExitFinished);
  ExpectAllTrue(run);
}

TEST(AuditedRunTest, AHostThatLiesIsNamedAndRefusedAndNothingOfItIsLearnt) {
  FakeRun run;
  run.setup.audit = {1, 1};
  for (const std::uint64_t id : {1, 2, 3}) run.AddActor(id);
  run.AddActor(12).status.vouched_host = "host2";  // another one of the liar's host
  run.actors.at(2).answer = Lie;
  run.actors.at(12).answer = Lie;
  EXPECT_EQ(run.Run(), process::kExitFinished);
  ExpectAllTrue(run);
  for (const std::uint64_t liar : {2, 12}) {
    EXPECT_NE(run.actors.at(liar).refused.find("host host2 ("), std::string::npos);
  }
  for (const std::uint64_t honest : {1, 3}) EXPECT_EQ(run.actors.at(honest).refused, "");
}

// Its other episodes of the batch are played again, though they were accepted.
TEST(AuditedRunTest, WhatAGuiltyHostBroughtBeforeIsTakenBack) {
  FakeRun run;
  run.setup.rules.episodes_per_update = 12;
  run.setup.rules.updates_total = 1;
  std::uint64_t key = 0;
  const auto chosen = [&](std::uint64_t number) {
    return trust::Audit({0.1, key}).IsChosen(number);
  };
  const auto count = [&] {
    int all = 0;
    for (std::uint64_t number = 0; number < 12; ++number) all += chosen(number) ? 1 : 0;
    return all;
  };
  while (!(count() == 1 && chosen(9))) ++key;  // the liar's lies before it are not audited
  run.setup.audit = {0.1, key};
  for (const std::uint64_t id : {1, 2, 3}) run.AddActor(id).answer = Lie;
  for (const std::uint64_t id : {11, 12, 13}) run.AddActor(id).duration = milliseconds(500);
  for (const std::uint64_t id : {1, 2, 3}) run.actors.at(id).status.vouched_host = "liar";
  EXPECT_EQ(run.Run(), process::kExitFinished);
  ExpectAllTrue(run);
}

TEST(AuditedRunTest, WhereTwoHostsDifferTheRunWaitsForAThird) {
  FakeRun run;
  run.setup.audit = {1, 1};
  run.AddActor(1);
  run.AddActor(2).answer = Lie;
  run.AddActor(22).status.vouched_host = "host2";  // cannot decide it
  run.actors.at(22).answer = Lie;
  FakeActor& third = run.AddActor(3);
  third.status.incarnation = 0;  // not yet
  ActorStatus comes = third.status;
  comes.incarnation = FakeRun::kIncarnation;
  run.bus.After(std::chrono::seconds(60), comes);
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_GT(run.bus.now() - Clock::time_point(std::chrono::hours(1)), std::chrono::seconds(60));
  ExpectAllTrue(run);
  EXPECT_NE(run.actors.at(2).refused, "");
  EXPECT_EQ(run.actors.at(1).refused, "");
}

// Two answers to one assignment, of which the check can tell neither, and no audit was due.
TEST(AuditedRunTest, WhatComesTwiceAndDiffersIsPlayedAgainByTwoHosts) {
  FakeRun run;
  run.setup.audit = {1e-9, 1};
  for (const std::uint64_t id : {1, 2, 3}) run.AddActor(id);
  run.actors.at(2).answer = [](const EpisodeMessage& truth) {
    std::vector<EpisodeMessage> both = Lie(truth);
    both.push_back(truth);
    return both;
  };
  EXPECT_EQ(run.Run(), process::kExitFinished);
  ExpectAllTrue(run);
  EXPECT_EQ(run.record.excluded.size(), 1U);
  EXPECT_TRUE(run.record.excluded.contains("host2"));
}

// Whatever its actors call themselves: it has one vote, and differs from itself or from the others.
TEST(AuditedRunTest, AMachineWithTwoInventedNamesDoesNotOutvoteAnHonestHost) {
  FakeRun run;
  run.setup.audit = {1, 1};
  run.AddActor(1);
  for (const std::uint64_t liar : {2, 3}) {
    FakeActor& actor = run.AddActor(liar);
    actor.status.vouched_host = "one machine";
    actor.answer = Lie;
  }
  run.AddActor(4).duration = milliseconds(5000);  // decides, when it comes to it
  EXPECT_EQ(run.Run(), process::kExitFinished);
  ExpectAllTrue(run);
  EXPECT_EQ(run.record.excluded.size(), 1U);
  EXPECT_TRUE(run.record.excluded.contains("one machine"));
}

TEST(AuditedRunTest, AnExcludedMachineDoesNotComeBackUnderAnotherName) {
  FakeRun run;
  run.setup.excluded = {{"one machine", "host one machine (liar:1) computes wrongly"}};
  FakeActor& liar = run.AddActor(2);
  liar.status.host = "never heard of";
  liar.status.vouched_host = "one machine";
  liar.answer = Lie;
  run.AddActor(1);
  EXPECT_EQ(run.Run(), process::kExitFinished);
  ExpectAllTrue(run);
  EXPECT_NE(liar.refused.find("computes wrongly"), std::string::npos);
}

TEST(AuditedRunTest, AnExclusionThatCouldNotBeWrittenIsWrittenLater) {
  FakeRun run;
  run.setup.audit = {1, 1};
  run.setup.rules.updates_total = 300;  // much longer than it waits before it tries again
  run.record.exclusions_to_fail = 2;
  for (const std::uint64_t id : {1, 2, 3}) run.AddActor(id);
  run.actors.at(2).answer = Lie;
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_EQ(run.record.exclusions_to_fail, 0);
  EXPECT_TRUE(run.record.excluded.contains("host2"));
}

TEST(AuditedRunTest, AnExclusionOutlivesTheLearner) {
  FakeRun first;
  first.setup.audit = {1, 1};
  for (const std::uint64_t id : {1, 2, 3}) first.AddActor(id);
  first.actors.at(2).answer = Lie;
  EXPECT_EQ(first.Run(), process::kExitFinished);
  ASSERT_TRUE(first.record.excluded.contains("host2"));

  FakeRun second;
  second.setup.excluded = first.record.excluded;
  second.AddActor(1);
  second.AddActor(2).answer = Lie;
  EXPECT_EQ(second.Run(), process::kExitFinished);
  ExpectAllTrue(second);
  EXPECT_NE(second.actors.at(2).refused.find("host host2 ("), std::string::npos);
  EXPECT_TRUE(second.record.excluded.empty()) << "written without need";
}

TEST(AuditedRunTest, AHostIsExcludedForGood) {
  FakeRun run;
  run.setup.audit = {1, 1};
  run.setup.rules.updates_total = 10;
  for (const std::uint64_t id : {1, 2, 3}) run.AddActor(id);
  run.actors.at(2).answer = Lie;
  FakeActor& back = run.AddActor(99);
  back.status.vouched_host = "host2";
  back.status.incarnation = 0;
  ActorStatus comes = back.status;
  comes.incarnation = FakeRun::kIncarnation;
  run.bus.After(std::chrono::seconds(5), comes);
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_NE(back.refused, "");
  ExpectAllTrue(run, 40);
}

/// A key by which `only` is the one of `numbers` that is audited.
std::uint64_t KeyThatChooses(double share, std::uint64_t only, std::uint64_t numbers) {
  for (std::uint64_t key = 0;; ++key) {
    const trust::Audit audit({share, key});
    bool found = true;
    for (std::uint64_t number = 0; number < numbers && found; ++number) {
      found = audit.IsChosen(number) == (number == only);
    }
    if (found) return key;
  }
}

/// When `refused` is turned away, all that `late` was ever asked for arrives, spoilt: it was under
/// way.
void SendLateWhenRefused(FakeRun& run, std::uint64_t refused, std::uint64_t late) {
  run.bus.on_assignment = [&run, refused, late,
                           obey = run.bus.on_assignment](const EpisodeAssignment& assignment) {
    if (assignment.kind == EpisodeAssignment::Kind::kRefuse && assignment.actor_id == refused) {
      const std::vector<EpisodeAssignment> sent = run.bus.assignments;
      for (const EpisodeAssignment& old : sent) {
        if (old.actor_id != late) continue;
        for (const std::uint64_t number : old.numbers) {
          const auto truth = FakeRun::MakeEpisode(number, old.weights_version);
          run.bus.After(milliseconds(0), Lie({FakeRun::kIncarnation, late, truth}).front());
        }
      }
    }
    return obey(assignment);
  };
}

/// Nothing that came late from the refused one's side entered.
void RunToTheTruthThoughRefused(FakeRun& run, std::uint64_t refused) {
  EXPECT_EQ(run.Run(), process::kExitFinished);
  ExpectAllTrue(run);
  EXPECT_NE(run.actors.at(refused).refused, "");
  EXPECT_GT(run.bus.statuses.back().rejected, 0U) << "nothing came late: the test tests nothing";
}

/// One update of 12 episodes.
void AuditOnlyNumber2(FakeRun& run) {
  run.setup.rules.episodes_per_update = 12;
  run.setup.rules.updates_total = 1;
  run.setup.audit = {0.1, KeyThatChooses(0.1, 2, 12)};
}

std::vector<EpisodeMessage> LieOnlyOn2(const EpisodeMessage& truth) {
  return truth.episode.number == 2 ? Lie(truth) : std::vector<EpisodeMessage>{};
}

// Nobody audits its other episodes, so nothing but its exclusion keeps them out.
TEST(AuditedRunTest, WhatAnExcludedHostHasUnderWayIsNotLearntFrom) {
  FakeRun run;
  AuditOnlyNumber2(run);
  run.AddActor(1);
  run.AddActor(2, 8).answer = LieOnlyOn2;
  run.AddActor(3);
  SendLateWhenRefused(run, 2, 2);
  RunToTheTruthThoughRefused(run, 2);
}

// The lost actor cannot be refused, but it may not be dead: its link may have been.
TEST(AuditedRunTest, WhatALostActorOfAnExcludedHostHasUnderWayIsNotLearntFrom) {
  FakeRun run;
  AuditOnlyNumber2(run);
  run.AddActor(1).duration = milliseconds(500);
  run.AddActor(2, 2).answer = LieOnlyOn2;
  FakeActor& lost = run.AddActor(22, 4);
  lost.status.vouched_host = "host2";
  lost.answer = [](const EpisodeMessage&) { return std::vector<EpisodeMessage>{}; };
  run.AddActor(3).duration = milliseconds(500);  // so that much of the lost one is still missing
  run.bus.CallAfter(milliseconds(350), [&run] { run.Kill(22); });
  SendLateWhenRefused(run, 2, 22);
  RunToTheTruthThoughRefused(run, 2);
}

// Else the opinion of a host that is excluded already would dispute that of the only one left.
TEST(AuditedRunTest, WhatAnExcludedHostSaysLateDoesNotHoldTheRunUp) {
  FakeRun run;
  run.setup.audit = {1, 1};
  for (const std::uint64_t id : {2, 22}) run.AddActor(id, 4).status.vouched_host = "host2";
  run.actors.at(22).answer = Lie;
  SendLateWhenRefused(run, 22, 22);
  FakeActor& honest = run.AddActor(1);
  honest.status.incarnation = 0;  // not yet
  ActorStatus comes = honest.status;
  comes.incarnation = FakeRun::kIncarnation;
  run.bus.After(std::chrono::seconds(4), comes);
  RunToTheTruthThoughRefused(run, 22);
}

// The other one was asked before it was lost, and its answer comes in the very moment in which
// waiting for it ends.
TEST(AuditedRunTest, AnAnswerInTheMomentInWhichAnotherWouldStandAloneIsHeardOnce) {
  FakeRun run;
  run.setup.rules.episodes_per_update = 1;
  run.setup.rules.updates_total = 1;
  run.setup.audit = {1, 1};
  run.AddActor(1);
  run.AddActor(2).answer = [&run](const EpisodeMessage& truth) {
    run.bus.After(milliseconds(0), ActorLost{2});
    run.bus.After(std::chrono::seconds(5), truth);
    return std::vector<EpisodeMessage>{};
  };
  EXPECT_EQ(run.Run(), process::kExitFinished);
  ExpectAllTrue(run, 1);
  EXPECT_EQ(run.bus.statuses.back().accepted, 1U);
}

}  // namespace
}  // namespace metronome::collect
