#include "common/dds/dds_bus.h"

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

#include "common/dds/endpoints.h"
#include "common/dds/inbox.h"
#include "common/dds/topics.h"
#include "tests/integration/dds_fixture.h"

namespace metronome::test {
namespace {

constexpr std::uint64_t kBig = 0xFEDCBA9876543210;  // an id with its highest bit set

class DdsBusTest : public testing::TestWithParam<Transport> {};

TEST_P(DdsBusTest, EveryMessageArrivesAsItWasSent) {
  const BusOptions options = FreshRun(GetParam());
  const auto learner = dds::MakeDdsLearnerBus(options);
  const auto actor = dds::MakeDdsActorBus(options, kBig);
  const RunDescription description = SomeDescription(kBig - 1, options.run_name);
  learner->Publish(description);
  EXPECT_EQ(Next<RunDescription>(*actor), description);
  const PolicySnapshot snapshot = SomeSnapshot(5);
  learner->Publish(snapshot);
  EXPECT_EQ(Next<PolicySnapshot>(*actor), snapshot);

  ASSERT_TRUE(Join(*learner, *actor, kBig));
  ActorStatus status = SomeStatus(kBig);
  actor->Send(status);
  status.vouched_host = "127.0.0.1";
  EXPECT_EQ(Next<ActorStatus>(*learner), status);
  EpisodeAssignment assignment = SomeAssignment(kBig, 40);
  assignment.kind = EpisodeAssignment::Kind::kRefuse;
  assignment.reason = "because";
  ASSERT_TRUE(learner->Send(assignment));
  EXPECT_EQ(Next<EpisodeAssignment>(*actor), assignment);

  const EpisodeMessage episode = SomeEpisode(40);
  ASSERT_EQ(actor->Send(episode), ActorBus::SendResult::kSent);
  const auto received = Next<EpisodeMessage>(*learner);
  ASSERT_TRUE(received);
  EXPECT_EQ(received->episode, episode.episode);
  EXPECT_EQ(received->actor_id, episode.actor_id);
  EXPECT_EQ(received->incarnation, episode.incarnation);
  EXPECT_GT(learner->bytes_sent(), 30000 * sizeof(float));
  EXPECT_GT(learner->bytes_received(), episode.episode.observation.size() * sizeof(float));
}

TEST_P(DdsBusTest, LateActorGetsTheDescriptionAndTheLastTwoSnapshots) {
  const BusOptions options = FreshRun(GetParam());
  const auto learner = dds::MakeDdsLearnerBus(options);
  RunDescription description = SomeDescription(1, options.run_name);
  learner->Publish(description);
  description.finished = true;
  learner->Publish(description);
  for (std::uint64_t version = 0; version < 5; ++version) learner->Publish(SomeSnapshot(version));
  const auto actor = dds::MakeDdsActorBus(options, 11);
  std::vector<std::uint64_t> versions;
  std::vector<RunDescription> descriptions;
  while (versions.size() < 2 || descriptions.empty()) {
    const auto event = actor->Wait(Soon());
    ASSERT_TRUE(event);
    if (const auto* snapshot = std::get_if<PolicySnapshot>(&*event)) {
      EXPECT_EQ(*snapshot, SomeSnapshot(snapshot->version));
      versions.push_back(snapshot->version);
    } else if (const auto* seen = std::get_if<RunDescription>(&*event)) {
      descriptions.push_back(*seen);
    }
  }
  EXPECT_EQ(versions, (std::vector<std::uint64_t>{3, 4}));
  EXPECT_EQ(descriptions, std::vector<RunDescription>{description});
}

TEST_P(DdsBusTest, SnapshotOfAMillionParametersArrives) {
  const BusOptions options = FreshRun(GetParam());
  const auto learner = dds::MakeDdsLearnerBus(options);
  const auto actor = dds::MakeDdsActorBus(options, 11);
  const PolicySnapshot snapshot = SomeSnapshot(1, 1'000'000);
  learner->Publish(snapshot);
  EXPECT_EQ(Next<PolicySnapshot>(*actor), snapshot);
}

/// Shared by the sending threads and the test.
struct Progress {
  std::mutex mutex;
  std::condition_variable changed;
  std::size_t sent = 0;
};

/// Sends every step-th episode from `first` on.
void SendEpisodes(ActorBus& actor, std::size_t first, std::size_t step, std::size_t end,
                  Progress& progress) {
  for (std::size_t number = first; number < end; number += step) {
    EXPECT_EQ(actor.Send(SomeEpisode(number)), ActorBus::SendResult::kSent);
    const std::lock_guard lock(progress.mutex);
    ++progress.sent;
    progress.changed.notify_all();
  }
}

TEST_P(DdsBusTest, SlowLearnerHoldsActorsBackAndLosesNothing) {
  constexpr std::size_t kHeld = dds::kEpisodeTopic.writer_depth + dds::kEpisodeTopic.reader_depth;
  constexpr std::size_t kEpisodes = 2 * kHeld;
  constexpr std::size_t kThreads = 3;
  constexpr std::size_t kBacklog = kHeld - 8;  // nearly what the two histories hold
  const BusOptions options = FreshRun(GetParam());
  const auto learner = ServingLearner(options);
  const auto actor = dds::MakeDdsActorBus(options, 11);
  ASSERT_TRUE(Next<RunDescription>(*actor));
  ASSERT_TRUE(Join(*learner, *actor, 11));
  Progress progress;
  std::vector<std::thread> senders;
  for (std::size_t first = 0; first < kThreads; ++first) {
    senders.emplace_back(
        [&, first] { SendEpisodes(*actor, first, kThreads, kEpisodes, progress); });
  }
  {
    std::unique_lock lock(progress.mutex);
    EXPECT_TRUE(
        progress.changed.wait_until(lock, Soon(), [&] { return progress.sent >= kBacklog; }));
    EXPECT_LT(progress.sent, kEpisodes) << "nothing held the senders back";
  }
  std::set<std::uint64_t> received;
  while (received.size() < kEpisodes) {
    const auto message = Next<EpisodeMessage>(*learner);
    if (!message) break;
    const std::uint64_t number = message->episode.number;
    EXPECT_TRUE(received.insert(number).second) << number << " came twice";
    EXPECT_EQ(message->episode, SomeEpisode(number).episode);
  }
  EXPECT_EQ(received.size(), kEpisodes);
  if (received.size() < kEpisodes) actor->Close(std::chrono::milliseconds(0));
  for (std::thread& sender : senders) sender.join();
}

INSTANTIATE_TEST_SUITE_P(Transports, DdsBusTest,
                         testing::Values(Transport::kUdp, Transport::kSharedMemory),
                         [](const auto& test) {
                           return test.param == Transport::kUdp ? "Udp" : "SharedMemory";
                         });

TEST(AgeSecondsTest, AreSecondsSinceTheSampleWasWritten) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  eprosima::fastdds::dds::SampleInfo info;
  info.source_timestamp.from_ns(std::chrono::nanoseconds(now - std::chrono::seconds(50)).count());
  EXPECT_NEAR(dds::AgeSeconds(info), 50, 5);
}

TEST(DdsBusTest, RunsOfOtherNamesAreNotHeard) {
  const BusOptions options = FreshRun();
  BusOptions other = options;
  other.run_name += "-other";
  const auto learner = dds::MakeDdsLearnerBus(options);
  const auto stranger = dds::MakeDdsLearnerBus(other);
  stranger->Publish(SomeDescription(1, other.run_name));
  learner->Publish(SomeDescription(2, options.run_name));
  const auto actor = dds::MakeDdsActorBus(options, 11);
  EXPECT_EQ(Next<RunDescription>(*actor), SomeDescription(2, options.run_name));
  stranger->Publish(SomeSnapshot(8));
  learner->Publish(SomeSnapshot(9));
  EXPECT_EQ(Next<PolicySnapshot>(*actor), SomeSnapshot(9));
}

TEST(DdsBusTest, AssignmentForAnActorThatIsNotThereIsRefused) {
  const auto learner = dds::MakeDdsLearnerBus(FreshRun());
  EXPECT_FALSE(learner->Send(SomeAssignment(11, 0)));
}

TEST(DdsBusTest, EpisodeWithoutALearnerIsRefused) {
  const auto actor = dds::MakeDdsActorBus(FreshRun(), 11);
  EXPECT_EQ(actor->Send(SomeEpisode(0)), ActorBus::SendResult::kNoLearner);
  actor->Close(std::chrono::milliseconds(0));
  EXPECT_EQ(actor->Send(SomeEpisode(0)), ActorBus::SendResult::kClosed);
}

TEST(DdsBusTest, AToolThatReadsEpisodesIsNoLearner) {
  const BusOptions options = FreshRun();
  const auto actor = dds::MakeDdsActorBus(options, 11);
  dds::Inbox inbox;
  dds::WriterWatch watch(&inbox);
  dds::Participant tool(options, "tool");
  const dds::Reader<wire::EpisodePubSubType> episodes(&tool, dds::kEpisodeTopic, &watch);
  // Found after the reader before it: once the actor reaches this one, it knows both.
  dds::Reader<wire::ActorStatusPubSubType> statuses(&tool, dds::kActorStatusTopic, &watch);
  const auto heard = [&] { return statuses.Take(); };
  for (const auto deadline = Soon(); Clock::now() < deadline;) {
    actor->Send(SomeStatus(11));
    if (inbox.Wait(Clock::now() + std::chrono::milliseconds(100), heard)) break;
    ASSERT_LT(Clock::now(), deadline) << "the tool hears nothing";
  }
  EXPECT_EQ(actor->Send(SomeEpisode(0)), ActorBus::SendResult::kNoLearner);
}

TEST(DdsBusTest, ActorThatLeavesIsReportedOnce) {
  const BusOptions options = FreshRun();
  const auto learner = dds::MakeDdsLearnerBus(options);
  {
    const auto actor = dds::MakeDdsActorBus(options, kBig);
    ASSERT_TRUE(Join(*learner, *actor, kBig));
  }
  const auto lost = Next<ActorLost>(*learner);
  ASSERT_TRUE(lost);
  EXPECT_EQ(lost->actor_id, kBig);
  EXPECT_FALSE(learner->Send(SomeAssignment(kBig, 0)));
  learner->Wake();
  const auto next = learner->Wait(Soon());
  ASSERT_TRUE(next);
  EXPECT_TRUE(std::holds_alternative<Woken>(*next));
}

TEST(DdsBusTest, LearnerThatLeavesAndItsSuccessorAreSeen) {
  const BusOptions options = FreshRun();
  const auto actor = dds::MakeDdsActorBus(options, 11);
  {
    const auto learner = dds::MakeDdsLearnerBus(options);
    learner->Publish(SomeDescription(5, options.run_name));
    ASSERT_TRUE(Next<RunDescription>(*actor));
  }
  const auto lost = Next<LearnerLost>(*actor);
  ASSERT_TRUE(lost);
  EXPECT_EQ(lost->learner_id, 5);
  const auto learner = dds::MakeDdsLearnerBus(options);
  RunDescription successor = SomeDescription(6, options.run_name);
  successor.incarnation = 4;
  learner->Publish(successor);
  EXPECT_EQ(Next<RunDescription>(*actor), successor);
}

TEST(DdsBusTest, LastWordsOfALearnerComeBeforeItsLoss) {
  const BusOptions options = FreshRun();
  const auto actor = dds::MakeDdsActorBus(options, 11);
  RunDescription description = SomeDescription(1, options.run_name);
  {
    const auto learner = dds::MakeDdsLearnerBus(options);
    learner->Publish(description);
    ASSERT_TRUE(Next<RunDescription>(*actor));
    description.finished = true;
    learner->Publish(description);
  }
  // While the actor looks elsewhere, the learner leaves and another one comes.
  const auto successor = dds::MakeDdsLearnerBus(options);
  for (const auto deadline = Soon(); Clock::now() < deadline;) {
    actor->Send(SomeStatus(11));
    if (Next<ActorStatus>(*successor, Clock::now() + std::chrono::milliseconds(100))) break;
  }
  const auto first = actor->Wait(Soon());
  ASSERT_TRUE(first && std::holds_alternative<RunDescription>(*first));
  EXPECT_EQ(std::get<RunDescription>(*first), description);
  const auto second = actor->Wait(Soon());
  ASSERT_TRUE(second && std::holds_alternative<LearnerLost>(*second));
  EXPECT_EQ(std::get<LearnerLost>(*second).learner_id, 1);
}

TEST(DdsBusTest, EachOfTwoLearnersThatLeaveTogetherIsReported) {
  const BusOptions options = FreshRun();
  const auto actor = dds::MakeDdsActorBus(options, 11);
  {
    const auto learner = dds::MakeDdsLearnerBus(options);
    learner->Publish(SomeDescription(1, options.run_name));
    ASSERT_TRUE(Next<RunDescription>(*actor));
    const auto rival = dds::MakeDdsLearnerBus(options);
    rival->Publish(SomeDescription(2, options.run_name));
    ASSERT_TRUE(Next<RunDescription>(*actor));
  }
  // Until the actor's end knows, without its looking at events.
  for (const auto deadline = Soon(); Clock::now() < deadline;) {
    if (actor->Send(SomeEpisode(0)) == ActorBus::SendResult::kNoLearner) break;
  }
  std::set<std::uint64_t> lost;
  for (int i = 0; i < 2; ++i) {
    const auto event = Next<LearnerLost>(*actor);
    ASSERT_TRUE(event) << i << " of 2 were reported";
    lost.insert(event->learner_id);
  }
  EXPECT_EQ(lost, (std::set<std::uint64_t>{1, 2}));
}

TEST(DdsBusTest, RivalLearnersSeeEachOtherComeAndGoButNeverThemselves) {
  const BusOptions options = FreshRun();
  const auto learner = dds::MakeDdsLearnerBus(options);
  learner->Publish(SomeDescription(1, options.run_name));
  {
    const auto rival = dds::MakeDdsLearnerBus(options);
    rival->Publish(SomeDescription(2, options.run_name));
    const auto seen = learner->Wait(Soon());
    ASSERT_TRUE(seen);
    ASSERT_TRUE(std::holds_alternative<RivalSeen>(*seen));
    EXPECT_EQ(std::get<RivalSeen>(*seen).description, SomeDescription(2, options.run_name));
    const auto seen_by_rival = Next<RivalSeen>(*rival);
    ASSERT_TRUE(seen_by_rival);
    EXPECT_EQ(seen_by_rival->description.learner_id, 1);
  }
  const auto lost = Next<RivalLost>(*learner);
  ASSERT_TRUE(lost);
  EXPECT_EQ(lost->learner_id, 2);
}

TEST(DdsBusTest, WakeEndsAWaitFromAnotherThread) {
  const auto learner = dds::MakeDdsLearnerBus(FreshRun());
  std::thread waker([&] { learner->Wake(); });
  EXPECT_TRUE(Next<Woken>(*learner));
  waker.join();
  EXPECT_FALSE(learner->Wait(Clock::now()));
}

TEST(DdsBusTest, BadOptionsAreNamed) {
  BusOptions options = FreshRun();
  options.run_name = "no*wildcards";
  EXPECT_THROW(dds::MakeDdsLearnerBus(options), std::invalid_argument);
  options = FreshRun();
  options.domain = 233;
  EXPECT_THROW(dds::MakeDdsActorBus(options, 1), std::invalid_argument);
}

}  // namespace
}  // namespace metronome::test
