#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "common/dds/dds_bus.h"
#include "tests/integration/dds_fixture.h"
#include "tests/integration/raw_writer.h"

namespace metronome::test {
namespace {

/// Bytes that encode nothing, and bytes that are almost right.
std::vector<Bytes> Corrupted(const Bytes& good) {
  std::vector<Bytes> all;
  for (const std::size_t size :
       {std::size_t{1}, std::size_t{3}, std::size_t{4}, std::size_t{7}, std::size_t{8},
        std::size_t{15}, good.size() / 2, good.size() - 4}) {
    all.emplace_back(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
  }
  Bytes longer = good;
  longer.insert(longer.end(), 8, 0);
  all.push_back(longer);
  for (std::size_t at = 0; at + 4 <= std::min<std::size_t>(good.size(), 240); at += 4) {
    Bytes huge = good;  // a length of 4 billion, among others
    std::memset(huge.data() + at, 0xff, 4);
    all.push_back(huge);
  }
  std::mt19937_64 random(1);
  for (int i = 0; i < 200; ++i) {
    Bytes flipped = good;
    for (int bit = 0; bit < 8; ++bit) {
      flipped[random() % std::min<std::size_t>(good.size(), 400)] ^=
          static_cast<char>(1 << (random() % 8));
    }
    all.push_back(flipped);
  }
  Bytes noise(512);
  for (char& byte : noise) byte = static_cast<char>(random());
  all.push_back(noise);
  return all;
}

/// Sends each corruption of `good`, then `good` itself, to the one reader of the topic.
/// @return bad samples reported before `good` arrived; std::nullopt if it never did.
template <class PubSubType, class Bus, class Message>
std::optional<int> BadSamplesBefore(const BusOptions& options, Bus& bus,
                                    const dds::TopicProfile& profile, const Message& good) {
  RawWriter attacker(options, profile, PubSubType().getName());
  if (!attacker.WaitForReader(Soon())) return std::nullopt;
  const Bytes bytes = Encode<PubSubType>(good);
  int bad = 0;
  for (const Bytes& corrupted : Corrupted(bytes)) {
    EXPECT_TRUE(attacker.Write(corrupted));
    while (const auto event = bus.Wait(Clock::now())) {
      if (const auto* sample = std::get_if<BadSample>(&*event)) {
        EXPECT_EQ(sample->topic, profile.name);
        EXPECT_FALSE(sample->reason.empty());
        ++bad;
      }
    }
  }
  EXPECT_TRUE(attacker.Write(bytes));
  const auto arrived = Next<Message>(bus);
  if (!arrived || Encode<PubSubType>(*arrived) != bytes) return std::nullopt;
  return bad;
}

// The corruptions of Corrupted() that no topic can take for a message: 8 truncations, a longer one.
constexpr int kSurelyBad = 9;

TEST(DdsHostileTest, EpisodesOfAnyBytesAreReportedAndSurvived) {
  const BusOptions options = FreshRun();
  const auto learner = dds::MakeDdsLearnerBus(options);
  const auto bad = BadSamplesBefore<wire::EpisodePubSubType>(options, *learner, dds::kEpisodeTopic,
                                                             SomeEpisode(123456789, 2));
  ASSERT_TRUE(bad);
  EXPECT_GE(*bad, kSurelyBad);
}

TEST(DdsHostileTest, StatusesOfAnyBytesAreReportedAndSurvived) {
  const BusOptions options = FreshRun();
  const auto learner = dds::MakeDdsLearnerBus(options);
  const auto bad = BadSamplesBefore<wire::ActorStatusPubSubType>(
      options, *learner, dds::kActorStatusTopic, SomeStatus(11));
  ASSERT_TRUE(bad);
  EXPECT_GE(*bad, kSurelyBad);
}

TEST(DdsHostileTest, DescriptionsOfAnyBytesAreReportedAndSurvived) {
  const BusOptions options = FreshRun();
  const auto actor = dds::MakeDdsActorBus(options, 11);
  const auto bad = BadSamplesBefore<wire::RunDescriptionPubSubType>(
      options, *actor, dds::kRunDescriptionTopic, SomeDescription(1, "x"));
  ASSERT_TRUE(bad);
  EXPECT_GE(*bad, kSurelyBad);
}

TEST(DdsHostileTest, SnapshotsOfAnyBytesAreReportedAndSurvived) {
  const BusOptions options = FreshRun();
  const auto actor = dds::MakeDdsActorBus(options, 11);
  const auto bad = BadSamplesBefore<wire::PolicySnapshotPubSubType>(
      options, *actor, dds::kPolicySnapshotTopic, SomeSnapshot(4, 50));
  ASSERT_TRUE(bad);
  // The checksum finds whatever changes a number; only a changed incarnation passes.
  EXPECT_GE(*bad, 200);
}

TEST(DdsHostileTest, LearnerStatusesOfAnyBytesAreReportedAndSurvived) {
  const BusOptions options = FreshRun();
  const auto observer = dds::MakeDdsObserverBus(options);
  const auto bad = BadSamplesBefore<wire::LearnerStatusPubSubType>(
      options, *observer, dds::kLearnerStatusTopic, SomeLearnerStatus(3));
  ASSERT_TRUE(bad);
  EXPECT_GE(*bad, kSurelyBad);
}

TEST(DdsHostileTest, AssignmentsOfAnyBytesAreSurvived) {
  const BusOptions options = FreshRun();
  const auto actor = dds::MakeDdsActorBus(options, 11);
  // The content filter may drop what does not say whom it is for, so bad samples are not counted.
  EXPECT_TRUE(BadSamplesBefore<wire::EpisodeAssignmentPubSubType>(
      options, *actor, dds::kEpisodeAssignmentTopic, SomeAssignment(11, 5)));
}

TEST(DdsHostileTest, StatusOfAnotherProtocolVersionTellsItsVersionAndWhoItIs) {
  const BusOptions options = FreshRun();
  const auto learner = dds::MakeDdsLearnerBus(options);
  const auto actor = dds::MakeDdsActorBus(options, 11);
  ActorStatus status = SomeStatus(11);
  status.protocol_version = kProtocolVersion + 7;
  ActorStatus header_alone;
  header_alone.protocol_version = kProtocolVersion + 7;
  header_alone.actor_id = 11;
  header_alone.incarnation = 3;
  header_alone.vouched_host = "127.0.0.1";
  std::optional<ActorStatus> seen;
  for (const auto deadline = Soon(); !seen && Clock::now() < deadline;) {
    actor->Send(status);  // nobody keeps it for a learner that is not matched yet
    seen = Next<ActorStatus>(*learner, Clock::now() + std::chrono::milliseconds(100));
  }
  EXPECT_EQ(seen, header_alone);
}

TEST(DdsHostileTest, DescriptionOfAnotherProtocolVersionTellsItsVersionToActorsAndRivals) {
  const BusOptions options = FreshRun();
  const auto actor = dds::MakeDdsActorBus(options, 11);
  const auto rival = dds::MakeDdsLearnerBus(options);
  const auto learner = dds::MakeDdsLearnerBus(options);
  RunDescription description = SomeDescription(1, options.run_name);
  description.protocol_version = kProtocolVersion + 7;
  RunDescription header_alone;
  header_alone.protocol_version = kProtocolVersion + 7;
  header_alone.learner_id = 1;
  header_alone.incarnation = 3;
  learner->Publish(description);
  EXPECT_EQ(Next<RunDescription>(*actor), header_alone);
  const auto seen = Next<RivalSeen>(*rival);
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->description, header_alone);
}

TEST(DdsHostileTest, EpisodeOfAnotherProtocolVersionIsReportedWithBothVersions) {
  const BusOptions options = FreshRun();
  const auto learner = dds::MakeDdsLearnerBus(options);
  RawWriter attacker(options, dds::kEpisodeTopic, wire::EpisodePubSubType().getName());
  ASSERT_TRUE(attacker.WaitForReader(Soon()));
  Bytes bytes = Encode<wire::EpisodePubSubType>(SomeEpisode(1, 1));
  bytes[4] = 42;  // behind the encapsulation: protocol_version, little-endian
  EXPECT_TRUE(attacker.Write(bytes));
  const auto bad = Next<BadSample>(*learner);
  ASSERT_TRUE(bad);
  EXPECT_EQ(bad->reason,
            "protocol version 42, this build speaks " + std::to_string(kProtocolVersion));
}

}  // namespace
}  // namespace metronome::test
