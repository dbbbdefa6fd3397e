#include <fastdds/rtps/builtin/data/ParticipantProxyData.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "common/dds/dds_bus.h"
#include "common/dds/endpoints.h"
#include "common/dds/participant_qos.h"
#include "tests/integration/dds_fixture.h"

/// The quality of service that live endpoints have, against the table of idl/README.md.
namespace metronome::test {
namespace {

namespace fdds = eprosima::fastdds::dds;

struct Expected {
  fdds::DurabilityQosPolicyKind durability;
  fdds::HistoryQosPolicyKind history;
  std::int32_t writer_depth;
  std::int32_t reader_depth;
};

template <class Qos>
void ExpectShared(const Qos& qos, const Expected& expected, std::int32_t depth) {
  EXPECT_EQ(qos.reliability().kind, fdds::RELIABLE_RELIABILITY_QOS);
  EXPECT_EQ(qos.durability().kind, expected.durability);
  EXPECT_EQ(qos.history().kind, expected.history);
  EXPECT_EQ(qos.history().depth, depth);
  EXPECT_EQ(qos.resource_limits().max_samples, depth);
  EXPECT_EQ(qos.resource_limits().max_instances, 1);
  EXPECT_EQ(qos.resource_limits().max_samples_per_instance, depth);
  EXPECT_EQ(qos.data_sharing().kind(), fdds::OFF);
}

template <class PubSubType>
void ExpectQos(const dds::TopicProfile& profile, const Expected& expected) {
  SCOPED_TRACE(profile.name);
  dds::Participant participant(FreshRun(), "test");
  const fdds::DataWriterQos writer =
      participant.MakeWriter<PubSubType>(profile, nullptr)->get_qos();
  ExpectShared(writer, expected, expected.writer_depth);
  EXPECT_EQ(writer.reliable_writer_qos().times.heartbeatPeriod,
            eprosima::fastrtps::Duration_t(0.05));
  EXPECT_EQ(writer.reliability().max_blocking_time, eprosima::fastrtps::Duration_t(0.02));
  const fdds::DataReaderQos reader =
      participant.MakeReader<PubSubType>(profile, nullptr)->get_qos();
  ExpectShared(reader, expected, expected.reader_depth);
}

TEST(DdsQosTest, LiveEndpointsHaveTheQualityOfServiceOfTheTable) {
  const auto transient = fdds::TRANSIENT_LOCAL_DURABILITY_QOS;
  const auto volatile_kind = fdds::VOLATILE_DURABILITY_QOS;
  const auto last = fdds::KEEP_LAST_HISTORY_QOS;
  const auto all = fdds::KEEP_ALL_HISTORY_QOS;
  ExpectQos<wire::RunDescriptionPubSubType>(dds::kRunDescriptionTopic, {transient, last, 1, 8});
  ExpectQos<wire::PolicySnapshotPubSubType>(dds::kPolicySnapshotTopic, {transient, last, 2, 8});
  ExpectQos<wire::EpisodeAssignmentPubSubType>(dds::kEpisodeAssignmentTopic,
                                               {volatile_kind, all, 4096, 1024});
  ExpectQos<wire::EpisodePubSubType>(dds::kEpisodeTopic, {volatile_kind, all, 32, 256});
  ExpectQos<wire::ActorStatusPubSubType>(dds::kActorStatusTopic, {volatile_kind, last, 4, 256});
  ExpectQos<wire::LearnerStatusPubSubType>(dds::kLearnerStatusTopic, {transient, last, 1, 8});
}

TEST(DdsQosTest, ParticipantsAreLostAfterTheirLease) {
  const auto qos = dds::ParticipantQos(FreshRun(), "test");
  const auto& discovery = qos.wire_protocol().builtin.discovery_config;
  EXPECT_EQ(discovery.leaseDuration, eprosima::fastrtps::Duration_t(2.5));
  EXPECT_EQ(discovery.leaseDuration_announcementperiod, eprosima::fastrtps::Duration_t(0.5));
}

/// The names of the participants of one run that one has discovered so far. Others may be in the
/// domain: those of another test, or of a real run on this machine.
class Sightings final : public fdds::DomainParticipantListener {
 public:
  using Info = eprosima::fastrtps::rtps::ParticipantDiscoveryInfo;

  explicit Sightings(std::string run) : run_(std::move(run)) {}

  void on_participant_discovery(fdds::DomainParticipant* /*participant*/,
                                Info&& discovered) override {
    const std::lock_guard lock(mutex_);
    if (discovered.status != Info::DISCOVERED_PARTICIPANT) return;
    const std::string name = discovered.info.m_participantName.to_string();
    if (!name.starts_with(run_)) return;
    names_.insert(name.substr(run_.size()));
    changed_.notify_all();
  }

  /// Blocks until all of them are seen, or it takes too long. @return whom this one has seen.
  std::set<std::string> WaitFor(const std::set<std::string>& names) {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, Soon(), [&] {
      return std::includes(names_.begin(), names_.end(), names.begin(), names.end());
    });
    return names_;
  }

 private:
  const std::string run_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::set<std::string> names_;
};

TEST(DdsQosTest, ActorsFindTheLearnerAndNotEachOther) {
  const BusOptions options = FreshRun();
  auto* factory = fdds::DomainParticipantFactory::get_instance();
  std::array<Sightings, 3> seen{Sightings(options.run_name + " "),
                                Sightings(options.run_name + " "),
                                Sightings(options.run_name + " ")};
  std::vector<fdds::DomainParticipant*> all;
  for (const std::string name : {"first", "second", "learner"}) {
    auto qos = dds::ParticipantQos(options, name == "learner" ? name : dds::kActorRole);
    qos.name(options.run_name + " " + name);
    all.push_back(factory->create_participant(options.domain, qos, &seen[all.size()],
                                              fdds::StatusMask::none()));
    ASSERT_NE(all.back(), nullptr);
  }
  EXPECT_EQ(seen[2].WaitFor({"first", "second"}), (std::set<std::string>{"first", "second"}));
  // The actors were there first: had they heard each other, they would have done so by then.
  EXPECT_EQ(seen[0].WaitFor({"learner"}), std::set<std::string>{"learner"});
  EXPECT_EQ(seen[1].WaitFor({"learner"}), std::set<std::string>{"learner"});
  for (auto* participant : all) factory->delete_participant(participant);
}

TEST(DdsQosTest, PeerOfAnotherQualityOfServiceIsReported) {
  const BusOptions options = FreshRun();
  const auto learner = dds::MakeDdsLearnerBus(options);
  const auto actor = dds::MakeDdsActorBus(options, 11);
  dds::TopicProfile forgetful = dds::kRunDescriptionTopic;
  forgetful.transient_local = false;
  dds::Participant stranger(options, "stranger");
  stranger.MakeWriter<wire::RunDescriptionPubSubType>(forgetful, nullptr);
  for (const auto& bad : {Next<BadSample>(*learner), Next<BadSample>(*actor)}) {
    ASSERT_TRUE(bad);
    EXPECT_EQ(bad->topic, dds::kRunDescriptionTopic.name);
    EXPECT_NE(bad->reason.find("quality of service"), std::string::npos);
  }
}

/// Whether anybody reads what one writer writes.
class AnyReader final : public dds::fdds::DataWriterListener {
 public:
  explicit AnyReader(dds::Inbox* inbox) : inbox_(inbox) {}

  /// As Inbox::Wait asks.
  std::optional<bool> there() const { return count_ > 0 ? std::optional(true) : std::nullopt; }
  void on_publication_matched(dds::fdds::DataWriter* /*writer*/,
                              const dds::fdds::PublicationMatchedStatus& status) override {
    count_ = status.current_count;
    inbox_->Notify();
  }

 private:
  dds::Inbox* const inbox_;
  std::atomic<int> count_{0};
};

TEST(DdsQosTest, ContentFilterLetsOnlyTheActorsOwnAssignmentsThrough) {
  const BusOptions options = FreshRun();
  constexpr std::uint64_t kMine = 0xFEDCBA9876543210;
  dds::Inbox inbox;
  dds::WriterWatch watch(&inbox);
  AnyReader readers(&inbox);
  dds::Participant sender(options, "sender");
  dds::Participant receiver(options, "receiver");
  dds::Writer<wire::EpisodeAssignmentPubSubType> writer(&sender, dds::kEpisodeAssignmentTopic,
                                                        &readers);
  dds::Reader<wire::EpisodeAssignmentPubSubType> reader(&receiver, dds::kEpisodeAssignmentTopic,
                                                        &watch, kMine);
  ASSERT_TRUE(inbox.Wait(Soon(), [&] { return readers.there(); }));
  for (const std::uint64_t id : {kMine - 1, kMine, kMine + 1, std::uint64_t{0}, kMine}) {
    EXPECT_EQ(writer.Write(SomeAssignment(id, 0)), dds::WriteResult::kWritten);
  }
  for (int expected = 0; expected < 2; ++expected) {
    const auto taken = inbox.Wait(Soon(), [&] { return reader.Take(); });
    ASSERT_TRUE(taken);
    EXPECT_EQ(std::get<EpisodeAssignment>(taken->content).actor_id, kMine);
  }
  EXPECT_TRUE(writer.WaitForAcknowledgements(seconds(20)));
  EXPECT_FALSE(reader.Take());
}

TEST(DdsQosTest, ARefusedSampleIsWrittenOnceThereIsRoom) {
  const dds::TopicProfile small{"metronome/small", false, true, 1, 1, 256};
  const BusOptions options = FreshRun();
  dds::Inbox inbox;
  dds::WriterWatch watch(&inbox);
  AnyReader readers(&inbox);
  dds::Participant sender(options, "sender");
  dds::Participant receiver(options, "receiver");
  dds::Writer<wire::EpisodeAssignmentPubSubType> writer(&sender, small, &readers);
  dds::Reader<wire::EpisodeAssignmentPubSubType> reader(&receiver, small, &watch);
  ASSERT_TRUE(inbox.Wait(Soon(), [&] { return readers.there(); }));
  std::uint64_t count = 0;  // of samples that nobody takes, until both histories are full
  const auto fits = [&] {
    return writer.WriteUntil(Clock::now() + std::chrono::milliseconds(500),
                             SomeAssignment(count, 0)) == dds::WriteResult::kWritten;
  };
  while (fits()) ASSERT_LT(++count, 10U);

  std::jthread writing([&] {
    EXPECT_EQ(writer.WriteUntil(Soon(), SomeAssignment(count, 0)), dds::WriteResult::kWritten);
  });
  for (std::uint64_t expected = 0; expected <= count; ++expected) {
    const auto taken = inbox.Wait(Soon(), [&] { return reader.Take(); });
    ASSERT_TRUE(taken);
    EXPECT_EQ(std::get<EpisodeAssignment>(taken->content).actor_id, expected);
  }
}

}  // namespace
}  // namespace metronome::test
