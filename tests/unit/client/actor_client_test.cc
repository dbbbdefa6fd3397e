#include "actor/client/actor_client.h"

#include <gtest/gtest.h>

#include <future>
#include <stdexcept>
#include <thread>

#include "common/config/config.h"
#include "common/policy/network.h"
#include "tests/unit/support/environments.h"
#include "tests/unit/support/fake_actor_bus.h"
#include "tests/unit/support/log_capture.h"

namespace metronome::client {
namespace {

constexpr std::uint64_t kActor = 77;

RunConfig SomeConfig() {
  RunConfig config;
  test::SetTask(config, "push");
  return config::Resolve(config);
}

RunDescription Describe(std::uint64_t incarnation, std::uint64_t learner_id = 1) {
  RunDescription description;
  description.learner_id = learner_id;
  description.incarnation = incarnation;
  description.run_name = "run";
  description.engine = "engine-1";
  description.config = SomeConfig().SerializeAsString();
  description.serving = true;
  return description;
}

PolicySnapshot Snapshot(std::uint64_t incarnation, std::uint64_t version) {
  PolicySnapshot snapshot;
  snapshot.incarnation = incarnation;
  snapshot.version = version;
  snapshot.parameters.assign(policy::ActorLayout(policy::ShapeOf(SomeConfig())).size, 0.5f);
  snapshot.observation_mean.assign(test::kObservationSize, 0);
  snapshot.observation_inv_std.assign(test::kObservationSize, 1);
  return snapshot;
}

EpisodeAssignment Assignment(std::uint64_t incarnation, std::uint64_t version,
                             std::vector<std::uint64_t> numbers) {
  EpisodeAssignment assignment;
  assignment.incarnation = incarnation;
  assignment.actor_id = kActor;
  assignment.weights_version = version;
  assignment.numbers = std::move(numbers);
  return assignment;
}

/// Shared by the players of a test: how many play right now, and how they should.
struct Stage {
  std::atomic<int> playing{0};
  std::atomic<int> most_at_once{0};
  std::atomic<int> cancelled{0};
  std::atomic<bool> hold{false};  // play on until released or cancelled
  std::atomic<int> meet{1};       // play on until so many play at once
  std::atomic<std::uint64_t> fail_at{~std::uint64_t{0}};
};

class FakePlayer final : public EpisodePlayer {
 public:
  explicit FakePlayer(Stage* stage) : stage_(stage) {}

  std::optional<Episode> Play(const PolicySnapshot& snapshot, std::uint64_t number,
                              const std::atomic<bool>& cancel) override {
    if (number == stage_->fail_at) throw std::runtime_error("the robot fell over");
    const int now = ++stage_->playing;
    int most = stage_->most_at_once;
    while (most < now && !stage_->most_at_once.compare_exchange_weak(most, now)) {
    }
    while (!cancel && (stage_->hold || stage_->most_at_once < stage_->meet)) {
      std::this_thread::yield();
    }
    --stage_->playing;
    if (cancel) {
      ++stage_->cancelled;
      return std::nullopt;
    }
    Episode episode;
    episode.number = number;
    episode.weights_version = snapshot.version;
    episode.reward.assign(5, 1);
    return episode;
  }

 private:
  Stage* const stage_;
};

class ActorClientTest : public testing::Test {
 protected:
  ActorClientTest() {
    options_.run_name = "run";
    options_.actor_id = kActor;
    options_.engine = "engine-1";
    options_.patience.reset();
  }

  ~ActorClientTest() override {
    if (!end_.valid()) return;
    stage_.hold = false;
    client_->Stop();
    end_.wait();
  }

  void Start() {
    client_ = std::make_unique<ActorClient>(
        &bus_,
        [this](const RunConfig& config, int envs) {
          if (set_up_fails_) throw std::runtime_error("no scene files");
          RunSetup setup;
          setup.canonical_digest = "digest of " + config.environment().task();
          for (int i = 0; i < envs; ++i) {
            setup.players.push_back(std::make_unique<FakePlayer>(&stage_));
          }
          return setup;
        },
        options_);
    end_ = std::async(std::launch::async, [this] { return client_->Run(); });
  }

  ActorEnd End() {
    if (end_.wait_for(std::chrono::seconds(20)) != std::future_status::ready) {
      ADD_FAILURE() << "the actor does not end";
      client_->Stop();
    }
    return end_.get();
  }

  bool WaitForEpisodes(std::size_t count) {
    return bus_.WaitUntil(
        [&](const auto& episodes, const auto&) { return episodes.size() >= count; });
  }

  bool WaitForStatusOf(std::uint64_t incarnation) {
    return bus_.WaitUntil([&](const auto&, const auto& statuses) {
      return !statuses.empty() && statuses.back().incarnation == incarnation;
    });
  }

  /// "number/version/incarnation" of what was published, sorted.
  std::vector<std::string> Published() const {
    std::vector<std::string> all;
    for (const EpisodeMessage& message : bus_.episodes()) {
      all.push_back(std::to_string(message.episode.number) + "/" +
                    std::to_string(message.episode.weights_version) + "/" +
                    std::to_string(message.incarnation));
    }
    std::sort(all.begin(), all.end());
    return all;
  }

  using Texts = std::vector<std::string>;

  Stage stage_;
  test::FakeActorBus bus_;
  ActorClientOptions options_;
  bool set_up_fails_ = false;
  std::unique_ptr<ActorClient> client_;
  std::future<ActorEnd> end_;
};

TEST_F(ActorClientTest, PlaysWhatIsAssignedAndEndsWhenTheRunIsFinished) {
  Start();
  bus_.Push(Describe(3));
  bus_.Push(Snapshot(3, 0));
  bus_.Push(Assignment(3, 0, {5, 6}));
  ASSERT_TRUE(WaitForEpisodes(2));
  EXPECT_EQ(Published(), (Texts{"5/0/3", "6/0/3"}));
  RunDescription finished = Describe(3);
  finished.finished = true;
  bus_.Push(finished);
  EXPECT_EQ(End(), ActorEnd::kFinished);
  EXPECT_TRUE(bus_.closed());
}

TEST_F(ActorClientTest, TellsTheLearnerWhoItIs) {
  options_.envs = 3;
  options_.host = "here";
  Start();
  bus_.Push(Describe(3));
  ASSERT_TRUE(bus_.WaitUntil([](const auto&, const auto& statuses) { return !statuses.empty(); }));
  bus_.WaitUntil([](const auto&, const auto& statuses) {
    const ActorStatus& status = statuses.front();
    EXPECT_EQ(status.actor_id, kActor);
    EXPECT_EQ(status.incarnation, 3);
    EXPECT_EQ(status.envs, 3);
    EXPECT_EQ(status.host, "here");
    EXPECT_EQ(status.engine, "engine-1");
    EXPECT_EQ(status.canonical_digest, "digest of push");
    return true;
  });
}

TEST_F(ActorClientTest, RepeatsItsStatusWhileNothingHappens) {
  options_.status_every = std::chrono::milliseconds(1);
  Start();
  bus_.Push(Describe(3));
  EXPECT_TRUE(bus_.WaitUntil([](const auto&, const auto& s) { return s.size() >= 5; }));
}

TEST_F(ActorClientTest, HoldsAnAssignmentUntilItsSnapshotIsThere) {
  Start();
  bus_.Push(Describe(3));
  bus_.Push(Snapshot(3, 0));
  bus_.Push(Assignment(3, 1, {8}));
  bus_.Push(Assignment(3, 0, {7}));
  ASSERT_TRUE(WaitForEpisodes(1));
  EXPECT_EQ(Published(), Texts{"7/0/3"});
  bus_.Push(Snapshot(3, 1));
  ASSERT_TRUE(WaitForEpisodes(2));
  EXPECT_EQ(Published(), (Texts{"7/0/3", "8/1/3"}));
}

TEST_F(ActorClientTest, TakesSnapshotAndAssignmentBeforeTheirDescription) {
  Start();
  bus_.Push(Assignment(3, 0, {7}));
  bus_.Push(Snapshot(3, 0));
  bus_.Push(Describe(3));
  ASSERT_TRUE(WaitForEpisodes(1));
  EXPECT_EQ(Published(), Texts{"7/0/3"});
}

TEST_F(ActorClientTest, NewestIncarnationRulesEvenWhenItsVersionIsOlder) {
  Start();
  bus_.Push(Describe(3));
  bus_.Push(Snapshot(3, 9));
  bus_.Push(Describe(4, 2));
  bus_.Push(Describe(3));  // an older one that goes on talking
  bus_.Push(Assignment(3, 9, {100}));
  bus_.Push(Snapshot(4, 2));
  bus_.Push(Assignment(4, 2, {7}));
  ASSERT_TRUE(WaitForEpisodes(1));
  EXPECT_EQ(Published(), Texts{"7/2/4"});
}

TEST_F(ActorClientTest, NewLearnerCancelsRunningEpisodesAndDropsTheQueue) {
  options_.envs = 2;
  stage_.hold = true;
  Start();
  bus_.Push(Describe(3));
  bus_.Push(Snapshot(3, 0));
  bus_.Push(Assignment(3, 0, {1, 2, 3, 4, 5}));
  while (stage_.playing < 2) std::this_thread::yield();
  bus_.Push(Describe(4));
  ASSERT_TRUE(WaitForStatusOf(4));
  EXPECT_EQ(stage_.cancelled, 2);
  stage_.hold = false;
  bus_.Push(Snapshot(4, 0));
  bus_.Push(Assignment(4, 0, {6}));
  ASSERT_TRUE(WaitForEpisodes(1));
  EXPECT_EQ(Published(), Texts{"6/0/4"});
}

TEST_F(ActorClientTest, EnvsPlayInParallel) {
  options_.envs = 4;
  stage_.meet = 4;  // nobody is done before four play at once
  Start();
  bus_.Push(Describe(3));
  bus_.Push(Snapshot(3, 0));
  bus_.Push(Assignment(3, 0, {1, 2, 3, 4}));
  ASSERT_TRUE(WaitForEpisodes(4));
  EXPECT_EQ(stage_.most_at_once, 4);
}

TEST_F(ActorClientTest, StartingLearnerIsNotObeyedBeforeItServes) {
  Start();
  RunDescription starting = Describe(5, 2);
  starting.serving = false;
  bus_.Push(starting);
  bus_.Push(Describe(3));
  ASSERT_TRUE(WaitForStatusOf(3));
  bus_.Push(Describe(5, 2));
  ASSERT_TRUE(WaitForStatusOf(5));
}

TEST_F(ActorClientTest, OfTwoLearnersOfOneIncarnationTheLowerIdIsObeyed) {
  Start();
  bus_.Push(Describe(3, 9));
  ASSERT_TRUE(WaitForStatusOf(3));
  bus_.Push(Describe(3, 4));
  bus_.Push(LearnerLost{9});  // not the obeyed one: changes nothing
  bus_.Push(LearnerLost{4});
  bus_.Push(Describe(2, 1));
  ASSERT_TRUE(WaitForStatusOf(2));
}

TEST_F(ActorClientTest, RemembersTheObeyedAndTheNewestOfManyLearners) {
  Start();
  bus_.Push(Describe(100, 1));
  ASSERT_TRUE(WaitForStatusOf(100));
  for (std::uint64_t id = 2; id < 100; ++id) bus_.Push(Describe(id, id));
  bus_.Push(LearnerLost{1});
  ASSERT_TRUE(WaitForStatusOf(99));
  for (std::uint64_t id = 99; id > 84; --id) bus_.Push(LearnerLost{id});
  bus_.Push(Describe(1, 200));
  ASSERT_TRUE(WaitForStatusOf(1)) << "an older learner than the 16 is still remembered";
}

TEST_F(ActorClientTest, SaysWhatItWaitsForWhenNothingIsAssigned) {
  const test::LogCapture log;
  options_.status_every = std::chrono::milliseconds(5);
  options_.idle_notice_every = std::chrono::milliseconds(20);
  Start();
  bus_.Push(Describe(1));
  ASSERT_TRUE(bus_.WaitUntil([](const auto&, const auto& sent) { return sent.size() > 20; }));
  bus_.Push(Assignment(1, 4, {0, 1}));
  ASSERT_TRUE(bus_.WaitUntil([](const auto&, const auto& sent) { return sent.size() > 40; }));
  bus_.Push(Snapshot(1, 4));
  ASSERT_TRUE(WaitForEpisodes(2));
  client_->Stop();
  EXPECT_EQ(End(), ActorEnd::kStopped);
  EXPECT_NE(log.text().find("has assigned nothing"), std::string::npos) << log.text();
  EXPECT_NE(log.text().find("no policy snapshot yet for 2 assigned episodes"), std::string::npos)
      << log.text();
}

TEST_F(ActorClientTest, GivesUpWithoutALearner) {
  options_.patience = std::chrono::milliseconds(20);
  options_.notice_every = std::chrono::milliseconds(5);
  Start();
  EXPECT_EQ(End(), ActorEnd::kNoLearner);
}

TEST_F(ActorClientTest, SaysOnceAndEarlyWhatToLookAtWhenNoLearnerIsHeard) {
  const test::LogCapture log;
  options_.why_no_learner = "look at the network";
  options_.patience = std::chrono::milliseconds(100);
  options_.notice_every = std::chrono::milliseconds(5);
  Start();
  EXPECT_EQ(End(), ActorEnd::kNoLearner);
  const std::string text = log.text();
  const auto first = text.find("look at the network");
  EXPECT_LT(first, text.find("giving up")) << text;
  EXPECT_EQ(text.find("look at the network", first + 1), std::string::npos) << text;
}

TEST_F(ActorClientTest, SaysWhatToLookAtWhereItGivesUpBeforeTheFirstNotice) {
  const test::LogCapture log;
  options_.why_no_learner = "look at the network";
  options_.patience = std::chrono::milliseconds(1);
  Start();
  EXPECT_EQ(End(), ActorEnd::kNoLearner);
  EXPECT_NE(log.text().find("giving up after 0 s: look at the network"), std::string::npos);
}

TEST_F(ActorClientTest, GivesUpWhenItsLearnerDoesNotComeBack) {
  options_.patience = std::chrono::milliseconds(500);
  Start();
  bus_.Push(Describe(3));
  ASSERT_TRUE(WaitForStatusOf(3));
  bus_.Push(LearnerLost{1});
  EXPECT_EQ(End(), ActorEnd::kNoLearner);
}

TEST_F(ActorClientTest, GoesOnWhenItsLearnerComesBack) {
  Start();
  bus_.Push(Describe(3));
  bus_.Push(Snapshot(3, 0));
  bus_.Push(LearnerLost{1});
  bus_.Push(Describe(3));
  bus_.Push(Assignment(3, 0, {7}));
  ASSERT_TRUE(WaitForEpisodes(1));
}

TEST_F(ActorClientTest, StaysForTheNextRunOfTheName) {
  options_.stay = true;
  Start();
  RunDescription finished = Describe(3);
  bus_.Push(finished);
  ASSERT_TRUE(WaitForStatusOf(3));
  finished.finished = true;
  bus_.Push(finished);
  bus_.Push(LearnerLost{1});
  bus_.Push(Describe(1, 2));  // a new folder counts from 1 again
  ASSERT_TRUE(WaitForStatusOf(1));
}

TEST_F(ActorClientTest, AnotherEngineIsRefused) {
  Start();
  RunDescription description = Describe(3);
  description.engine = "engine-2";
  bus_.Push(description);
  EXPECT_EQ(End(), ActorEnd::kRefused);
}

TEST_F(ActorClientTest, AnotherProtocolVersionIsRefused) {
  Start();
  RunDescription description = Describe(3);
  description.protocol_version = kProtocolVersion + 1;
  bus_.Push(description);
  EXPECT_EQ(End(), ActorEnd::kRefused);
}

TEST_F(ActorClientTest, StrangerOfAnotherProtocolVersionDoesNotEndARun) {
  Start();
  bus_.Push(Describe(3));
  RunDescription stranger = Describe(9, 5);
  stranger.protocol_version = kProtocolVersion + 1;
  bus_.Push(stranger);
  bus_.Push(Snapshot(3, 0));
  bus_.Push(Assignment(3, 0, {7}));
  EXPECT_TRUE(WaitForEpisodes(1));
}

TEST_F(ActorClientTest, RefusalByTheLearnerEndsIt) {
  Start();
  bus_.Push(Describe(3));
  EpisodeAssignment refusal = Assignment(3, 0, {});
  refusal.kind = EpisodeAssignment::Kind::kRefuse;
  refusal.reason = "another digest";
  bus_.Push(refusal);
  EXPECT_EQ(End(), ActorEnd::kRefused);
}

TEST_F(ActorClientTest, WhatMakesNoSenseIsDropped) {
  Start();
  RunDescription elsewhere = Describe(8, 5);
  elsewhere.run_name = "another run";
  bus_.Push(elsewhere);
  RunDescription garbled = Describe(9, 6);
  garbled.config = "no Protobuf";
  bus_.Push(garbled);
  bus_.Push(BadSample{"topic", "reason"});
  bus_.Push(Describe(3));
  PolicySnapshot narrow = Snapshot(3, 0);
  narrow.parameters.pop_back();
  bus_.Push(narrow);
  bus_.Push(Assignment(3, 0, {6}));
  PolicySnapshot infinite = Snapshot(3, 1);
  infinite.parameters.front() = std::numeric_limits<float>::infinity();
  bus_.Push(infinite);
  bus_.Push(Assignment(3, 1, {7}));
  PolicySnapshot wild = Snapshot(3, 2);  // finite, but the std is not
  wild.parameters.back() = 89;
  bus_.Push(wild);
  bus_.Push(Assignment(3, 2, {8}));
  PolicySnapshot huge = Snapshot(3, 3);  // finite, but the means are not
  huge.parameters.assign(huge.parameters.size(), 3e38F);
  std::fill(huge.parameters.end() - 40, huge.parameters.end(), 0.0F);
  bus_.Push(huge);
  bus_.Push(Assignment(3, 3, {9}));
  bus_.Push(Snapshot(3, 4));
  bus_.Push(Assignment(3, 4, {10}));
  ASSERT_TRUE(WaitForEpisodes(1));
  EXPECT_EQ(Published(), Texts{"10/4/3"});
}

TEST_F(ActorClientTest, PlayersExceptionEndsIt) {
  stage_.fail_at = 7;
  Start();
  bus_.Push(Describe(3));
  bus_.Push(Snapshot(3, 0));
  bus_.Push(Assignment(3, 0, {7}));
  EXPECT_THROW(End(), std::runtime_error);
  EXPECT_TRUE(bus_.closed());
}

TEST_F(ActorClientTest, FailedSetUpIsToldApart) {
  set_up_fails_ = true;
  Start();
  bus_.Push(Describe(3));
  EXPECT_THROW(End(), SetUpFailed);
}

TEST_F(ActorClientTest, StopEndsItInTheMiddleOfAnEpisode) {
  stage_.hold = true;
  Start();
  bus_.Push(Describe(3));
  bus_.Push(Snapshot(3, 0));
  bus_.Push(Assignment(3, 0, {7}));
  while (stage_.playing < 1) std::this_thread::yield();
  client_->Stop();
  EXPECT_EQ(End(), ActorEnd::kStopped);
  EXPECT_TRUE(Published().empty());
}

TEST(AssignmentBookTest, RefusesMoreThanItHolds) {
  AssignmentBook book;
  book.Obey(1);
  EpisodeAssignment assignment = Assignment(1, 0, std::vector<std::uint64_t>(1024));
  for (std::size_t held = 0; held < AssignmentBook::kMaxHeldNumbers; held += 1024) {
    ASSERT_TRUE(book.Add(assignment));
  }
  EXPECT_FALSE(book.Add(assignment));
  book.Add(Snapshot(1, 0));
  EXPECT_EQ(book.TakeReady().size(), AssignmentBook::kMaxHeldNumbers);
  EXPECT_EQ(book.held(), 0);
  EXPECT_TRUE(book.Add(assignment));
}

TEST(AssignmentBookTest, ForgetsAssignmentsOfLearnersThatWereOvertaken) {
  AssignmentBook book;
  ASSERT_TRUE(book.Add(Assignment(5, 0, {1})));
  book.Obey(6);
  EXPECT_EQ(book.held(), 0U) << "one that came before its successor was obeyed";
  ASSERT_TRUE(book.Add(Assignment(5, 0, {2, 3})));
  EXPECT_EQ(book.held(), 0U) << "one that came after";
  ASSERT_TRUE(book.Add(Assignment(7, 0, {4})));
  EXPECT_EQ(book.held(), 1U) << "its learner may be obeyed next";
  book.Obey(2);
  EXPECT_EQ(book.held(), 1U);
  ASSERT_TRUE(book.Add(Assignment(2, 0, {5})));
  book.Obey(3);
  EXPECT_EQ(book.held(), 1U) << "an assignment of the learner before";
}

TEST(AssignmentBookTest, ForgetsAssignmentsWhoseSnapshotWasOvertaken) {
  AssignmentBook book;
  book.Obey(1);
  ASSERT_TRUE(book.Add(Assignment(1, 3, {30})));
  ASSERT_TRUE(book.Add(Assignment(1, 4, {40})));
  book.Add(Snapshot(1, 4));
  EXPECT_EQ(book.TakeReady().size(), 1U);
  EXPECT_EQ(book.held(), 1U) << "with overlap 1, batch 4 is played under version 3";
  book.Add(Snapshot(2, 9));
  EXPECT_EQ(book.held(), 1U) << "a snapshot of another learner says nothing";
  book.Add(Snapshot(1, 5));
  EXPECT_EQ(book.held(), 0U);
  ASSERT_TRUE(book.Add(Assignment(1, 3, {31})));
  EXPECT_EQ(book.held(), 0U) << "topics are not ordered: the snapshot may come first";
  ASSERT_TRUE(book.Add(Assignment(1, 6, {60})));
  EXPECT_EQ(book.held(), 1U);
}

TEST(AssignmentBookTest, SnapshotsThatCameBeforeTheirLearnerWasObeyedCountToo) {
  AssignmentBook book;
  ASSERT_TRUE(book.Add(Assignment(1, 3, {30})));
  book.Add(Snapshot(1, 5));
  EXPECT_EQ(book.held(), 1U);
  book.Obey(1);
  EXPECT_EQ(book.held(), 0U);
}

}  // namespace
}  // namespace metronome::client
