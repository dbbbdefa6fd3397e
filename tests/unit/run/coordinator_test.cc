#include "learner/run/coordinator.h"

#include <gtest/gtest.h>

#include <csignal>
#include <numeric>

#include "common/process/exit_codes.h"
#include "tests/unit/support/fake_run.h"
#include "tests/unit/support/log_capture.h"

namespace metronome::run {
namespace {

using ::metronome::testing::FakeActor;
using ::metronome::testing::FakeRun;
using std::chrono::milliseconds;
using std::chrono::seconds;

std::vector<std::uint64_t> FirstNumbers(std::uint64_t count) {
  std::vector<std::uint64_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0U);
  return numbers;
}

RunDescription Rival(std::uint64_t id, bool serving) {
  RunDescription rival;
  rival.learner_id = id;
  rival.serving = serving;
  rival.run_name = "test";
  rival.build = "build-2, on elsewhere";
  return rival;
}

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(CoordinatorTest, ARunLearnsFromEachNumberOnceInOrderAndEndsWithItsAccounts) {
  FakeRun run;
  run.AddActor(1);
  run.AddActor(2, 2);
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_EQ(run.learning.learnt, FirstNumbers(12));
  EXPECT_EQ(run.record.updates, (std::vector<std::uint64_t>{1, 2, 3}));
  EXPECT_EQ(run.record.finished,
            "every episode number entered exactly one update: 12 of 12 (reassigned 0, duplicates "
            "0, rejected 0)");
  EXPECT_TRUE(run.bus.descriptions.back().finished);
  EXPECT_LT(run.bus.waits, 200) << "it polls";
}

TEST(CoordinatorTest, MoreEnvsThanHalfOfTheEpisodesAreOneWarning) {
  const std::string warning = "envs beyond half of that are often idle";
  for (const std::uint32_t envs : {1U, 2U}) {
    const test::LogCapture log;
    FakeRun run;  // of 4 episodes an update
    for (std::uint64_t id = 1; id <= 2; ++id) run.AddActor(id, envs);
    EXPECT_EQ(run.Run(), process::kExitFinished);
    const std::string text = log.text();
    const auto first = text.find(warning);
    EXPECT_EQ(Contains(text, "4 envs for 4 episodes an update: " + warning), envs == 2) << text;
    EXPECT_EQ(Contains(text, "--set collection.episodes_per_update=8"), envs == 2) << text;
    EXPECT_EQ(text.rfind(warning), first) << text;
  }
}

TEST(CoordinatorTest, WhoeverWatchesIsToldOnceASecondAndAtTheEnd) {
  FakeRun run;
  run.setup.status = {"push", "here", 42, {120, 3, false}};
  std::vector<LearnerStatus> shown;
  run.setup.on_status = [&shown](const LearnerStatus& status) { shown.push_back(status); };
  run.AddActor(1, 2).duration = milliseconds(3000);
  EXPECT_EQ(run.Run(), process::kExitFinished);
  const auto& statuses = run.bus.statuses;
  EXPECT_EQ(shown, statuses);
  ASSERT_GT(statuses.size(), 5U);
  EXPECT_EQ(statuses.front().state, LearnerStatus::State::kWaitingForActors);
  EXPECT_EQ(statuses[1].state, LearnerStatus::State::kCollecting);
  for (std::size_t i = 1; i + 1 < statuses.size(); ++i) {
    EXPECT_NEAR(statuses[i].seconds - statuses[i - 1].seconds, 1, 1e-9) << i;
  }
  const LearnerStatus& last = statuses.back();
  EXPECT_EQ(last.state, LearnerStatus::State::kFinished);
  EXPECT_EQ(last.task, "push");
  EXPECT_EQ(last.host, "here");
  EXPECT_EQ(last.incarnation, FakeRun::kIncarnation);
  EXPECT_EQ(last.version, 3U);
  EXPECT_EQ(last.steps, 120U);
  EXPECT_EQ(last.eta_seconds, 0);
  EXPECT_EQ(last.accepted, 12U);
  EXPECT_EQ(last.checkpoint_version, 3U);
}

TEST(CoordinatorTest, AStatusShowsEachActorAndTheAgeOfItsOldestAssignment) {
  FakeRun run;
  FakeActor& actor = run.AddActor(1, 2);
  actor.duration = milliseconds(1900);
  actor.status.pid = 5;
  actor.status.steps_per_second = 250;
  EXPECT_EQ(run.Run(), process::kExitFinished);
  const LearnerStatus& second = run.bus.statuses.at(1);
  ASSERT_EQ(second.actors.size(), 1U);
  EXPECT_EQ(second.actors_total, 1U);
  EXPECT_EQ(second.envs_total, 2U);
  const ActorReport& shown = second.actors.front();
  EXPECT_EQ(shown.name, "host1:5");
  EXPECT_EQ(shown.envs, 2U);
  EXPECT_EQ(shown.steps_per_second, 250);
  EXPECT_EQ(shown.assignments, 2U);
  EXPECT_NEAR(shown.oldest_assignment_seconds, 0.999, 1e-9);
  EXPECT_NEAR(shown.silent_seconds, 0.999, 1e-9);
  EXPECT_FALSE(shown.on_probation);
  EXPECT_FALSE(shown.unanswering);
}

// Names are host:process, so each start of an actor is one more.
TEST(CoordinatorTest, AStatusCountsTheEpisodesOfAnActorThatCameAfterAThousandOthers) {
  FakeRun run;
  run.AddActor(5000).duration = milliseconds(300);
  const auto comes_after = [&run](milliseconds delay, FakeActor& actor) {
    actor.status.incarnation = 0;  // not yet
    ActorStatus comes = actor.status;
    comes.incarnation = FakeRun::kIncarnation;
    run.bus.After(delay, comes);
  };
  for (std::uint64_t id = 1; id <= 1500; ++id) {
    FakeActor& other = run.AddActor(id);
    other.answer = [](const EpisodeMessage&) { return std::vector<EpisodeMessage>{}; };
    const milliseconds then(310 + id);
    comes_after(then, other);
    run.bus.After(then, EpisodeMessage{FakeRun::kIncarnation, id, FakeRun::MakeEpisode(99, 0)});
    run.bus.After(then, ActorLost{id});
  }
  comes_after(milliseconds(2000), run.AddActor(6000));
  std::map<std::string, std::uint64_t> accepted;
  run.setup.on_status = [&accepted](const LearnerStatus& status) {
    for (const ActorReport& actor : status.actors) accepted[actor.name] = actor.accepted;
  };
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_GT(accepted.at("host6000:0"), 0U);
  EXPECT_GT(accepted.at("host5000:0"), 0U) << "who is there keeps its counts";
}

TEST(CoordinatorTest, ARunOfEpisodesThatEndEarlyEndsWithTheUpdateThatReachesItsSteps) {
  for (const std::uint64_t overlap : {0U, 1U}) {
    FakeRun run;
    run.setup.rules.overlap = overlap;
    run.setup.rules.updates_total = 1000;  // if each episode had one step
    run.setup.total_steps = 90;            // an update brings 40
    run.setup.status.length = {90, 2, true};
    run.setup.checkpoint_every = 100;
    run.AddActor(1, 2);
    EXPECT_EQ(run.Run(), process::kExitFinished);
    EXPECT_EQ(run.learning.current.version, 3U);
    EXPECT_EQ(run.learning.learnt, FirstNumbers(12));
    EXPECT_EQ(run.record.finished.find("every episode number entered exactly one update: 12 of 12"),
              0U)
        << run.record.finished;
    EXPECT_EQ(run.record.saved.back().version, 3U);
    EXPECT_EQ(run.bus.statuses.back().updates_total, 3U);
  }
}

TEST(CoordinatorTest, AStoppedRunSaysSoToWhoeverWatches) {
  FakeRun run;
  run.AddActor(1);
  run.bus.CallAfter(milliseconds(2500), [&run] { run.coordinator->RequestStop(SIGTERM); });
  run.setup.rules.updates_total = 100;
  EXPECT_EQ(run.Run(), process::kExitSignalBase + SIGTERM);
  EXPECT_EQ(run.bus.statuses.back().state, LearnerStatus::State::kStopped);
}

TEST(CoordinatorTest, VersionZeroIsOnDiskBeforeTheFirstAssignmentAndEachVersionAfterIt) {
  FakeRun run;
  run.AddActor(1);
  EXPECT_EQ(run.Run(), process::kExitFinished);
  ASSERT_EQ(run.record.saved.size(), 4U);
  EXPECT_EQ(run.record.saved[0].version, 0U);
  EXPECT_EQ(run.record.assignments_before_save[0], 0U);
  EXPECT_EQ(run.record.saved[1].canonical_digest, "digest-1");
  EXPECT_EQ(run.record.saved[3].version, 3U);
}

TEST(CoordinatorTest, CheckpointsAreWrittenEveryFewUpdatesAndAtTheEnd) {
  FakeRun run;
  run.setup.rules.updates_total = 5;
  run.setup.checkpoint_every = 2;
  run.AddActor(1);
  EXPECT_EQ(run.Run(), process::kExitFinished);
  std::vector<std::uint64_t> versions;
  for (const checkpoint::TrainState& state : run.record.saved) versions.push_back(state.version);
  EXPECT_EQ(versions, (std::vector<std::uint64_t>{0, 2, 4, 5}));
}

TEST(CoordinatorTest, MilestonesAreWrittenBetweenCheckpoints) {
  FakeRun run;
  run.setup.rules.updates_total = 7;
  run.setup.checkpoint_every = 5;
  run.setup.milestone_every = 3;
  run.AddActor(1);
  EXPECT_EQ(run.Run(), process::kExitFinished);
  std::vector<std::uint64_t> versions;
  for (const checkpoint::TrainState& state : run.record.saved) versions.push_back(state.version);
  EXPECT_EQ(versions, (std::vector<std::uint64_t>{0, 3, 5, 6, 7}));
}

TEST(CoordinatorTest, WithoutOverlapNothingIsAssignedDuringAnUpdate) {
  FakeRun run;
  run.AddActor(1, 2);
  bool assigned_during_update = false;
  const auto obey = run.bus.on_assignment;
  run.bus.on_assignment = [&](const EpisodeAssignment& assignment) {
    assigned_during_update |= run.background.running;
    return obey(assignment);
  };
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_FALSE(assigned_during_update);
  EXPECT_EQ(run.learning.behaviour,
            (std::vector<std::uint64_t>{0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2}));
}

TEST(CoordinatorTest, WithOverlapTheNextBatchIsPlayedUnderTheOldWeightsDuringTheUpdate) {
  FakeRun run;
  run.setup.rules.overlap = 1;
  run.AddActor(1, 2);
  bool assigned_during_update = false;
  const auto obey = run.bus.on_assignment;
  run.bus.on_assignment = [&](const EpisodeAssignment& assignment) {
    assigned_during_update |= run.background.running;
    EXPECT_LE(assignment.weights_version, run.bus.snapshots.back().version);
    return obey(assignment);
  };
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_TRUE(assigned_during_update);
  EXPECT_EQ(run.learning.learnt, FirstNumbers(12));
  EXPECT_EQ(run.learning.behaviour,
            (std::vector<std::uint64_t>{0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1}));
}

TEST(CoordinatorTest, AResumedRunGoesOnWithTheSameNumbersAndPublishesBothVersions) {
  FakeRun run;
  run.Resume(2);
  run.setup.rules.overlap = 1;
  run.AddActor(1);
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_EQ(run.learning.learnt, (std::vector<std::uint64_t>{8, 9, 10, 11}));
  EXPECT_EQ(run.learning.behaviour, (std::vector<std::uint64_t>{1, 1, 1, 1}));
  EXPECT_EQ(run.bus.snapshots[0].version, 1U);
  EXPECT_EQ(run.bus.snapshots[1].version, 2U);
  EXPECT_EQ(run.bus.snapshots[1].incarnation, FakeRun::kIncarnation);
  ASSERT_EQ(run.record.saved.size(), 1U) << "the checkpoint gone on from is not written again";
  EXPECT_TRUE(Contains(run.record.finished, "12 of 12"));
  EXPECT_TRUE(Contains(run.record.finished, "8 before the last resume"));
}

TEST(CoordinatorTest, AFinishedRunThatIsResumedEndsAtOnce) {
  FakeRun run;
  run.Resume(3);
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_TRUE(run.bus.assignments.empty());
  EXPECT_TRUE(Contains(run.record.finished, "12 of 12"));
}

TEST(CoordinatorTest, WallClockFactsAreOfTheBatchsOwnCollection) {
  FakeRun run;
  run.setup.seconds_before = 100;
  run.AddActor(1);
  EXPECT_EQ(run.Run(), process::kExitFinished);
  ASSERT_EQ(run.record.walls.size(), 3U);
  const record::WallReport& wall = run.record.walls[1];
  EXPECT_NEAR(wall.collect_seconds, 0.4, 1e-9);  // four episodes of 100 ms in one env
  EXPECT_EQ(wall.idle_share, 0) << "the second of the update before is no idleness of collecting";
  EXPECT_NEAR(wall.seconds, 100 + 0.001 + 0.4 + 1 + 0.4 + 1, 1e-9);
  EXPECT_EQ(wall.envs, 1U);
}

TEST(CoordinatorTest, AKilledActorsEpisodesAreAssignedToTheOthers) {
  FakeRun run;
  run.AddActor(1);
  run.AddActor(2);
  run.bus.CallAfter(milliseconds(350), [&] { run.Kill(1); });
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_EQ(run.learning.learnt, FirstNumbers(12));
  EXPECT_FALSE(Contains(run.record.finished, "reassigned 0"));
}

TEST(CoordinatorTest, BadEpisodesNeverReachTheUpdateAndAreReassigned) {
  FakeRun run;
  int sent = 0;
  run.AddActor(1).answer = [&](EpisodeMessage message) {
    if (++sent % 3 == 0) message.episode.reward[0] = std::nanf("");
    return std::vector{message};
  };
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_EQ(run.learning.learnt, FirstNumbers(12));
  EXPECT_TRUE(Contains(run.record.finished, "rejected 5")) << run.record.finished;
}

TEST(CoordinatorTest, AnActorThatOnlySendsBadEpisodesIsRefusedByName) {
  FakeRun run;
  FakeActor& bad = run.AddActor(1);
  bad.duration = milliseconds(1);
  bad.answer = [](EpisodeMessage message) {
    message.episode.reward[0] = std::nanf("");
    return std::vector{message};
  };
  run.AddActor(2);
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_TRUE(Contains(bad.refused, "host1")) << bad.refused;
  EXPECT_TRUE(Contains(bad.refused, "a reward is not finite"));
  EXPECT_EQ(run.learning.learnt, FirstNumbers(12));
}

TEST(CoordinatorTest, DuplicatesAreDroppedAndADifferingOneIsToldInTheAccounts) {
  FakeRun run;
  run.AddActor(1).answer = [](const EpisodeMessage& message) {
    EpisodeMessage again = message;
    if (message.episode.number == 5) again.episode.reward[0] += 1;
    return std::vector{message, again};
  };
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_EQ(run.learning.learnt, FirstNumbers(12));
  EXPECT_TRUE(Contains(run.record.finished, "duplicates 12, rejected 0, DIFFERING DUPLICATES 1"))
      << run.record.finished;
}

TEST(CoordinatorTest, SamplesOfAnotherStartOfTheLearnerAreDropped) {
  FakeRun run;
  run.AddActor(1).answer = [](const EpisodeMessage& message) {
    EpisodeMessage stale = message;
    stale.incarnation = FakeRun::kIncarnation - 1;
    stale.episode.reward[0] = -1;
    return std::vector{stale, message};
  };
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_TRUE(Contains(run.record.finished, "duplicates 0, rejected 0"));
}

TEST(CoordinatorTest, SamplesFromNowhereAreCountedAndDropped) {
  FakeRun run;
  run.AddActor(1);
  run.bus.After(milliseconds(400), BadSample{"episode", "truncated"});
  run.bus.After(milliseconds(400),
                EpisodeMessage{FakeRun::kIncarnation, 66, FakeRun::MakeEpisode(2, 0)});
  run.bus.After(milliseconds(400),
                EpisodeMessage{FakeRun::kIncarnation, 1, FakeRun::MakeEpisode(999, 0)});
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_TRUE(Contains(run.record.finished, "rejected 3")) << run.record.finished;
}

TEST(CoordinatorTest, ActorsOfAnotherProtocolEngineOrArithmeticAreRefusedNamingBothSides) {
  FakeRun run;
  run.AddActor(1);
  FakeActor& protocol = run.AddActor(2);
  protocol.status.protocol_version = kProtocolVersion + 1;
  FakeActor& engine = run.AddActor(3);
  engine.status.engine = "engine-2";
  FakeActor& digest = run.AddActor(4);
  digest.status.canonical_digest = "digest-2";
  digest.status.build = "build-4";
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_TRUE(run.actors.at(1).refused.empty());
  EXPECT_TRUE(Contains(protocol.refused, "protocol version " +
                                             std::to_string(kProtocolVersion + 1) +
                                             ", the learner " + std::to_string(kProtocolVersion)))
      << protocol.refused;
  EXPECT_TRUE(Contains(engine.refused, "engine-1") && Contains(engine.refused, "engine-2"));
  for (const char* part : {"host4", "digest-1", "digest-2", "build-1", "build-4"}) {
    EXPECT_TRUE(Contains(digest.refused, part)) << part << " in " << digest.refused;
  }
}

// The wire carries 4096 characters of a reason; whoever exceeds them cannot be told anything.
TEST(CoordinatorTest, ARefusalFitsTheWireHoweverLongAnActorsWordsAre) {
  FakeRun run;
  run.AddActor(1).status.build = std::string(4000, 'w');
  FakeActor& build = run.AddActor(2);
  build.status.canonical_digest = "digest-2";
  build.status.build = std::string(4000, 'x');
  FakeActor& engine = run.AddActor(3);
  engine.status.engine = std::string(5000, 'y');
  EXPECT_EQ(run.Run(), process::kExitFinished);
  for (const char* part :
       {"host2", "digest-1", "digest-2", "www...", "xxx...", "same version of Metronome"}) {
    EXPECT_TRUE(Contains(build.refused, part)) << part;
  }
  EXPECT_LT(build.refused.size(), 2000U);
  EXPECT_EQ(engine.refused.size(), 4096U);
}

TEST(CoordinatorTest, AfterAResumeActorsMustEqualTheCheckpointsDigest) {
  FakeRun run;
  run.Resume(1);
  FakeActor& other = run.AddActor(1);
  other.status.canonical_digest = "digest-2";
  run.AddActor(2);
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_TRUE(Contains(other.refused, "digest-1"));
}

TEST(CoordinatorTest, AfterAResumeTheDigestOfAnOlderBuildIsCompletedOnce) {
  const std::string older(64, 'a');
  const std::string whole = older + std::string(64, 'b');
  FakeRun run;
  run.Resume(1);
  run.setup.canonical_digest = older;
  FakeActor& longer = run.AddActor(1);
  longer.status.canonical_digest = whole + "b";
  run.AddActor(2).status.canonical_digest = whole;
  FakeActor& other = run.AddActor(3);
  other.status.canonical_digest = older + std::string(64, 'c');
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_TRUE(Contains(longer.refused, older)) << longer.refused;
  EXPECT_TRUE(run.actors.at(2).refused.empty()) << run.actors.at(2).refused;
  EXPECT_TRUE(Contains(other.refused, whole)) << other.refused;
  EXPECT_EQ(run.record.saved.back().canonical_digest, whole);
}

TEST(CoordinatorTest, AFullDiskIsLoudAndTheRunGoesOn) {
  FakeRun run;
  run.record.full = [](std::uint64_t version) { return version == 1 || version == 2; };
  run.AddActor(1);
  EXPECT_EQ(run.Run(), process::kExitFinished);
  ASSERT_EQ(run.record.saved.size(), 2U);
  EXPECT_EQ(run.record.saved[1].version, 3U);
}

TEST(CoordinatorTest, AFinalCheckpointThatCannotBeWrittenIsAFailure) {
  FakeRun run;
  run.record.full = [](std::uint64_t version) { return version == 3; };
  run.AddActor(1);
  EXPECT_EQ(run.Run(), process::kExitFailure);
  EXPECT_TRUE(run.bus.descriptions.back().finished);
}

TEST(CoordinatorTest, WithoutAVersionZeroCheckpointNothingIsAssigned) {
  FakeRun run;
  run.record.full = [](std::uint64_t) { return true; };
  run.AddActor(1);
  EXPECT_EQ(run.Run(), process::kExitFailure);
  EXPECT_TRUE(run.bus.assignments.empty());
  EXPECT_FALSE(run.record.started_at.has_value());
}

TEST(CoordinatorTest, AnUpdateThatIsNotFiniteStopsTheRunWithTheLastGoodCheckpoint) {
  FakeRun run;
  run.setup.checkpoint_every = 10;
  run.learning.fail_at = 3;
  run.AddActor(1);
  EXPECT_EQ(run.Run(), process::kExitNonFinite);
  EXPECT_EQ(run.record.saved.back().version, 2U);
  EXPECT_FALSE(run.bus.descriptions.back().finished);
  EXPECT_TRUE(run.record.finished.empty());
}

TEST(CoordinatorTest, ASignalStopsWithACheckpointOfTheLastCompleteVersion) {
  FakeRun run;
  run.setup.checkpoint_every = 10;
  run.AddActor(1);
  run.bus.CallAfter(milliseconds(300 + 450 + 1000 + 100),
                    [&] { run.coordinator->RequestStop(SIGINT); });
  EXPECT_EQ(run.Run(), 130);
  EXPECT_EQ(run.record.saved.back().version, 1U);
  EXPECT_TRUE(run.record.interrupted);
  EXPECT_FALSE(run.bus.descriptions.back().finished) << "actors are to wait for the resumed one";
}

TEST(CoordinatorTest, ASignalWithoutACheckpointIsAFailureAndNothingIsSaidToBeOnDisk) {
  FakeRun run;
  run.record.full = [](std::uint64_t version) { return version == 1; };
  run.AddActor(1);
  run.bus.CallAfter(milliseconds(300 + 450 + 1000 + 100),
                    [&] { run.coordinator->RequestStop(SIGINT); });
  EXPECT_EQ(run.Run(), process::kExitFailure);
  EXPECT_EQ(run.record.updates.back(), 1U);
  EXPECT_EQ(run.record.saved.back().version, 0U);
  EXPECT_FALSE(run.record.interrupted);
  EXPECT_EQ(run.bus.statuses.back().state, LearnerStatus::State::kStopped);
  EXPECT_EQ(run.bus.statuses.back().checkpoint_version, 0U);
}

TEST(CoordinatorTest, ASignalDuringAnUpdateKeepsItsResultAndBeginsNoOther) {
  FakeRun run;
  run.setup.checkpoint_every = 10;
  run.AddActor(1);
  run.bus.CallAfter(milliseconds(300 + 450 + 500), [&] { run.coordinator->RequestStop(SIGTERM); });
  EXPECT_EQ(run.Run(), 143);
  EXPECT_EQ(run.record.saved.back().version, 1U);
  EXPECT_EQ(run.learning.learnt, FirstNumbers(4));
  EXPECT_EQ(run.record.updates, (std::vector<std::uint64_t>{1}));
}

TEST(CoordinatorTest, ARunWithoutActorsWaitsWithoutPolling) {
  FakeRun run;
  run.bus.CallAfter(seconds(3600), [&] { run.coordinator->RequestStop(SIGINT); });
  EXPECT_EQ(run.Run(), 130);
  EXPECT_LT(run.bus.waits,
            3600 + 3600 / 5 + 20);  // a status a second, a call for actors every five
}

TEST(CoordinatorTest, AnActorThatComesLateIsServed) {
  FakeRun run;
  FakeActor& late = run.AddActor(1);
  late.status.incarnation = 0;  // what it says before it has heard of this learner
  ActorStatus knows = late.status;
  knows.incarnation = FakeRun::kIncarnation;
  run.bus.After(seconds(30), knows);
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_GT(run.bus.now() - Clock::time_point(std::chrono::hours(1)), seconds(30));
}

// Rivals. Start: looks for 300 ms; a lease is 3 s.

TEST(CoordinatorTest, NobodyElseIsSeenSoTheRunIsServedAfterTheDiscoveryTime) {
  FakeRun run;
  run.AddActor(1);
  FakeActor& actor = run.actors.at(1);
  std::optional<Clock::time_point> served;
  const auto hear = run.bus.on_description;
  run.bus.on_description = [&](const RunDescription& description) {
    if (description.serving && !served) served = run.bus.now();
    hear(description);
  };
  EXPECT_EQ(run.Run(), process::kExitFinished);
  EXPECT_FALSE(run.bus.descriptions.front().serving);
  EXPECT_EQ(*served, Clock::time_point(std::chrono::hours(1)) + milliseconds(300));
  EXPECT_TRUE(actor.refused.empty());
}

TEST(CoordinatorTest, ALivingLearnerRefusesASecondOneAndLeavesItsFilesAlone) {
  FakeRun run;
  run.bus.After(milliseconds(50), RivalSeen{Rival(999, true)});
  EXPECT_EQ(run.Run(), process::kExitRival);
  EXPECT_FALSE(run.record.begun);
  EXPECT_EQ(run.bus.now(), Clock::time_point(std::chrono::hours(1)) + milliseconds(3050));
}

TEST(CoordinatorTest, OnesOwnGhostVanishesWithinItsLeaseAndDoesNotRefuse) {
  FakeRun run;
  run.AddActor(1);
  run.bus.After(milliseconds(10), RivalSeen{Rival(1, true)});
  run.bus.After(milliseconds(2900), RivalLost{1});
  EXPECT_EQ(run.Run(), process::kExitFinished);
}

TEST(CoordinatorTest, OfTwoThatStartTheLowerIdGoesOnAtOnceAndTheHigherGivesUp) {
  FakeRun lower;
  lower.AddActor(1);
  lower.bus.After(milliseconds(10), RivalSeen{Rival(FakeRun::kLearnerId + 1, false)});
  EXPECT_EQ(lower.Run(), process::kExitFinished);
  FakeRun higher;
  higher.bus.After(milliseconds(10), RivalSeen{Rival(FakeRun::kLearnerId - 1, false)});
  EXPECT_EQ(higher.Run(), process::kExitRival);
}

TEST(CoordinatorTest, OfTwoEstablishedOnesTheHigherIdStopsWithACheckpoint) {
  FakeRun run;
  run.setup.rules.updates_total = 30;
  run.setup.checkpoint_every = 100;
  run.AddActor(1);
  run.bus.After(seconds(10), RivalSeen{Rival(FakeRun::kLearnerId - 1, true)});
  EXPECT_EQ(run.Run(), process::kExitRival);
  EXPECT_GT(run.record.saved.back().version, 0U);
  EXPECT_EQ(run.record.saved.back().version, run.learning.current.version);
}

TEST(CoordinatorTest, AnEstablishedLearnerOutlastsALaterOne) {
  FakeRun run;
  run.setup.rules.updates_total = 30;
  run.AddActor(1);
  // The newcomer yields within two leases, whichever id is lower.
  run.bus.After(seconds(10), RivalSeen{Rival(FakeRun::kLearnerId - 1, true)});
  run.bus.After(seconds(16), RivalLost{FakeRun::kLearnerId - 1});
  run.bus.After(seconds(20), RivalSeen{Rival(FakeRun::kLearnerId + 1, true)});
  EXPECT_EQ(run.Run(), process::kExitFinished);
}

TEST(CoordinatorTest, ANewcomerThatMissedTheEstablishedOneYieldsEvenWithTheLowerId) {
  FakeRun run;
  run.setup.rules.updates_total = 30;
  run.AddActor(1);
  run.bus.After(seconds(1), RivalSeen{Rival(FakeRun::kLearnerId + 1, true)});
  EXPECT_EQ(run.Run(), process::kExitRival);
}

TEST(CoordinatorTest, AStartingRivalNeverStopsTheOneThatServes) {
  FakeRun run;
  run.AddActor(1);
  run.bus.After(seconds(1), RivalSeen{Rival(1, false)});
  EXPECT_EQ(run.Run(), process::kExitFinished);
}

TEST(BackgroundThreadTest, WorkRunsElsewhereOneAtATimeAndWaitSeesItsEnd) {
  BackgroundThread background("test");
  int sum = 0;
  std::thread::id where;
  for (int i = 1; i <= 3; ++i) {
    background.Start([&sum, &where, i] {
      sum += i;
      where = std::this_thread::get_id();
    });
    background.Wait();
  }
  EXPECT_EQ(sum, 6);
  EXPECT_NE(where, std::this_thread::get_id());
}

}  // namespace
}  // namespace metronome::run
