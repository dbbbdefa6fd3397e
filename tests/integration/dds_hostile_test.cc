#include <gtest/gtest.h>

#include <cstring>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <random>

#include "common/dds/convert.h"
#include "common/dds/dds_bus.h"
#include "common/dds/endpoints.h"
#include "common/dds/participant_qos.h"
#include "common/dds/peer_watch.h"
#include "tests/integration/dds_fixture.h"

namespace metronome::test {
namespace {

namespace fdds = eprosima::fastdds::dds;
using Bytes = std::vector<char>;
using Payload = eprosima::fastrtps::rtps::SerializedPayload_t;

/// A type of any name whose samples are the bytes that they are given.
class RawType final : public fdds::TopicDataType {
 public:
  explicit RawType(const char* name) {
    setName(name);
    m_typeSize = 1024;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, Payload* payload) override {
    const auto& bytes = *static_cast<Bytes*>(data);
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    return true;
  }
  bool deserialize(Payload*, void*) override { return false; }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes(); }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, fdds::InstanceHandle_t*, bool) override { return false; }
};

/// The bytes that a correct peer would send.
template <class PubSubType, class Message>
Bytes Encode(const Message& message) {
  PubSubType type;
  auto sample = dds::ToWire(message);
  Payload payload(type.getSerializedSizeProvider(&sample)());
  EXPECT_TRUE(type.serialize(&sample, &payload));
  const char* data = reinterpret_cast<const char*>(payload.data);
  return Bytes(data, data + payload.length);
}

/// Publishes raw bytes on one topic of a run.
class Attacker {
 public:
  template <class PubSubType>
  Attacker(const BusOptions& options, const dds::TopicProfile& profile, PubSubType type)
      : factory_(fdds::DomainParticipantFactory::get_instance()),
        participant_(factory_->create_participant(options.domain,
                                                  dds::ParticipantQos(options, "attacker"))) {
    fdds::TypeSupport(new RawType(type.getName())).register_type(participant_);
    fdds::PublisherQos qos = fdds::PUBLISHER_QOS_DEFAULT;
    qos.partition().push_back(options.run_name.c_str());
    writer_ = participant_->create_publisher(qos)->create_datawriter(
        participant_->create_topic(profile.name, type.getName(), fdds::TOPIC_QOS_DEFAULT),
        Qos(profile), &watch_);
  }
  ~Attacker() {
    participant_->delete_contained_entities();
    factory_->delete_participant(participant_);
  }

  bool WaitForReader() {
    return inbox_
        .Wait(Soon(), [this] { return watch_.HasReader() ? std::optional(true) : std::nullopt; })
        .has_value();
  }

  void Write(Bytes bytes) {
    while (writer_->write(&bytes, fdds::HANDLE_NIL) != dds::ReturnCode::RETCODE_OK) {
    }
    // One at a time, so that keep-last topics carry each.
    EXPECT_EQ(writer_->wait_for_acknowledgments({20, 0}), dds::ReturnCode::RETCODE_OK);
  }

 private:
  static fdds::DataWriterQos Qos(const dds::TopicProfile& profile) {
    fdds::DataWriterQos qos = dds::WriterQos(profile);
    qos.reliable_writer_qos().times.heartbeatPeriod = {0, 2'000'000};  // acknowledged soon
    return qos;
  }

  dds::Inbox inbox_;
  dds::ReaderWatch watch_{&inbox_};
  fdds::DomainParticipantFactory* const factory_;
  fdds::DomainParticipant* const participant_;
  fdds::DataWriter* writer_ = nullptr;
};

/// What is not an encoding of anything, and what is almost right.
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
  Attacker attacker(options, profile, PubSubType());
  if (!attacker.WaitForReader()) return std::nullopt;
  const Bytes bytes = Encode<PubSubType>(good);
  int bad = 0;
  for (const Bytes& corrupted : Corrupted(bytes)) {
    attacker.Write(corrupted);
    while (const auto event = bus.Wait(Clock::now())) {
      if (const auto* sample = std::get_if<BadSample>(&*event)) {
        EXPECT_EQ(sample->topic, profile.name);
        EXPECT_FALSE(sample->reason.empty());
        ++bad;
      }
    }
  }
  attacker.Write(bytes);
  const auto arrived = Next<Message>(bus);
  if (!arrived || Encode<PubSubType>(*arrived) != bytes) return std::nullopt;
  return bad;
}

// The corruptions of Corrupted() that no topic can take for a message: 8 truncations, a longer one.
constexpr int kSurelyBad = 9;

TEST(DdsHostileTest, EpisodesOfAnyBytesAreReportedAndSurvived) {
  const BusOptions options = FreshRun();
  const auto learner = MakeDdsLearnerBus(options);
  const auto bad = BadSamplesBefore<wire::EpisodePubSubType>(options, *learner, dds::kEpisodeTopic,
                                                             SomeEpisode(123456789, 2));
  ASSERT_TRUE(bad);
  EXPECT_GE(*bad, kSurelyBad);
}

TEST(DdsHostileTest, StatusesOfAnyBytesAreReportedAndSurvived) {
  const BusOptions options = FreshRun();
  const auto learner = MakeDdsLearnerBus(options);
  const auto bad = BadSamplesBefore<wire::ActorStatusPubSubType>(
      options, *learner, dds::kActorStatusTopic, SomeStatus(11));
  ASSERT_TRUE(bad);
  EXPECT_GE(*bad, kSurelyBad);
}

TEST(DdsHostileTest, DescriptionsOfAnyBytesAreReportedAndSurvived) {
  const BusOptions options = FreshRun();
  const auto actor = MakeDdsActorBus(options, 11);
  const auto bad = BadSamplesBefore<wire::RunDescriptionPubSubType>(
      options, *actor, dds::kRunDescriptionTopic, SomeDescription(1, "x"));
  ASSERT_TRUE(bad);
  EXPECT_GE(*bad, kSurelyBad);
}

TEST(DdsHostileTest, SnapshotsOfAnyBytesAreReportedAndSurvived) {
  const BusOptions options = FreshRun();
  const auto actor = MakeDdsActorBus(options, 11);
  const auto bad = BadSamplesBefore<wire::PolicySnapshotPubSubType>(
      options, *actor, dds::kPolicySnapshotTopic, SomeSnapshot(4, 50));
  ASSERT_TRUE(bad);
  // The checksum finds whatever changes a number; only a changed incarnation passes.
  EXPECT_GE(*bad, 200);
}

TEST(DdsHostileTest, OrdersOfAnyBytesAreSurvived) {
  const BusOptions options = FreshRun();
  const auto actor = MakeDdsActorBus(options, 11);
  // The content filter may drop what does not say whom it is for, so bad samples are not counted.
  EXPECT_TRUE(BadSamplesBefore<wire::EpisodeOrderPubSubType>(
      options, *actor, dds::kEpisodeOrderTopic, SomeOrder(11, 5)));
}

TEST(DdsHostileTest, StatusOfAnotherProtocolVersionTellsItsVersionAndWhoItIs) {
  const BusOptions options = FreshRun();
  const auto learner = MakeDdsLearnerBus(options);
  const auto actor = MakeDdsActorBus(options, 11);
  ActorStatus status = SomeStatus(11);
  status.protocol_version = kProtocolVersion + 7;
  ActorStatus header_alone;
  header_alone.protocol_version = kProtocolVersion + 7;
  header_alone.actor_id = 11;
  header_alone.incarnation = 3;
  std::optional<ActorStatus> seen;
  for (const auto deadline = Soon(); !seen && Clock::now() < deadline;) {
    actor->Send(status);  // nobody keeps it for a learner that is not matched yet
    seen = Next<ActorStatus>(*learner, Clock::now() + std::chrono::milliseconds(100));
  }
  EXPECT_EQ(seen, header_alone);
}

TEST(DdsHostileTest, DescriptionOfAnotherProtocolVersionTellsItsVersionToActorsAndRivals) {
  const BusOptions options = FreshRun();
  const auto actor = MakeDdsActorBus(options, 11);
  const auto rival = MakeDdsLearnerBus(options);
  const auto learner = MakeDdsLearnerBus(options);
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
  const auto learner = MakeDdsLearnerBus(options);
  Attacker attacker(options, dds::kEpisodeTopic, wire::EpisodePubSubType());
  ASSERT_TRUE(attacker.WaitForReader());
  Bytes bytes = Encode<wire::EpisodePubSubType>(SomeEpisode(1, 1));
  bytes[4] = 42;  // behind the encapsulation: protocol_version, little-endian
  attacker.Write(bytes);
  const auto bad = Next<BadSample>(*learner);
  ASSERT_TRUE(bad);
  EXPECT_EQ(bad->reason,
            "protocol version 42, this build speaks " + std::to_string(kProtocolVersion));
}

}  // namespace
}  // namespace metronome::test
