#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <fastdds/dds/core/LoanableSequence.hpp>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/dds/actor_filter.h"
#include "common/dds/convert.h"
#include "common/dds/tcp.h"
#include "common/messages/bus_options.h"
#include "tests/integration/dds_fixture.h"

namespace metronome::dds {
namespace {

using test::SomeAssignment;
using test::SomeDescription;
using test::SomeEpisode;
using test::SomeSnapshot;
using test::SomeStatus;

/// Why the sample is refused; empty if it is not.
template <class Wire>
std::string Complaint(const Wire& sample) {
  try {
    FromWire(sample);
    return "";
  } catch (const Malformed& error) {
    return error.what();
  }
}

TEST(ConvertTest, EpisodeWhoseArraysDisagreeIsRefused) {
  const wire::Episode good = ToWire(SomeEpisode(1, 10));
  EXPECT_EQ(Complaint(good), "");
  wire::Episode bad = good;
  bad.observation().pop_back();
  EXPECT_EQ(Complaint(bad), "observation has 428 elements, which make no 11 rows of 1 to 1024");
  bad = good;
  bad.action().push_back(0);
  EXPECT_EQ(Complaint(bad), "action has 41 elements, which make no 10 rows of 1 to 64");
  bad = good;
  bad.log_prob().clear();
  EXPECT_EQ(Complaint(bad), "log_prob has 0 elements instead of 10");
  bad = good;
  bad.head().resize(9);
  EXPECT_EQ(Complaint(bad), "head has 9 elements instead of 10");
  bad = good;
  bad.flags().resize(11);
  EXPECT_EQ(Complaint(bad), "flags has 11 elements instead of 10");
  EXPECT_NE(Complaint(wire::Episode()), "");
}

TEST(ConvertTest, EpisodesBeyondTheCeilingsAreRefusedBothWays) {
  EXPECT_NO_THROW(ToWire(SomeEpisode(1, 10000)));
  EXPECT_THROW(ToWire(SomeEpisode(1, 10001)), Malformed);
  EpisodeMessage wide = SomeEpisode(1, 2);
  wide.episode.observation.assign(3 * 1024, 0);
  wide.episode.action.assign(2 * 64, 0);
  EXPECT_NO_THROW(ToWire(wide));
  EpisodeMessage wider = wide;
  wider.episode.observation.assign(3 * 1025, 0);
  EXPECT_THROW(ToWire(wider), Malformed);
  wider = wide;
  wider.episode.action.assign(2 * 65, 0);
  EXPECT_THROW(ToWire(wider), Malformed);
}

TEST(ConvertTest, SnapshotWithOneChangedBitIsRefused) {
  const wire::PolicySnapshot good = ToWire(SomeSnapshot(7, 100));
  EXPECT_EQ(Complaint(good), "");
  for (const auto change : {+[](wire::PolicySnapshot& s) { s.version(s.version() ^ 1); },
                            +[](wire::PolicySnapshot& s) { s.parameters()[99] += 1; },
                            +[](wire::PolicySnapshot& s) { s.observation_mean()[0] += 1; },
                            +[](wire::PolicySnapshot& s) { s.observation_inv_std()[38] += 1; },
                            +[](wire::PolicySnapshot& s) { s.checksum(s.checksum() ^ 1); }}) {
    wire::PolicySnapshot bad = good;
    change(bad);
    EXPECT_NE(Complaint(bad), "");
  }
}

TEST(ConvertTest, SnapshotChecksumIsCrc32OfVersionAndNumbers) {
  PolicySnapshot snapshot;
  snapshot.version = 1;
  snapshot.parameters = {1.0f};
  // zlib.crc32(struct.pack("<Qf", 1, 1.0)) in Python.
  EXPECT_EQ(SnapshotChecksum(snapshot), 0x6D953F76u);
}

TEST(ConvertTest, AssignmentOfUnknownKindIsRefused) {
  wire::EpisodeAssignment assignment = ToWire(SomeAssignment(1, 2));
  EXPECT_EQ(Complaint(assignment), "");
  assignment.kind(2);
  EXPECT_EQ(Complaint(assignment), "kind 2 of assignment is unknown");
}

TEST(ConvertTest, LearnerStatusSurvivesTheWire) {
  const LearnerStatus status = test::SomeLearnerStatus(3);
  EXPECT_EQ(FromWire(ToWire(status)), status);
}

TEST(ConvertTest, LearnerStatusOfMoreActorsThanTheWireCarriesListsTheFirstAndCountsAll) {
  const LearnerStatus status = test::SomeLearnerStatus(3, wire::kMaxActorReports + 5);
  const LearnerStatus arrived = FromWire(ToWire(status));
  EXPECT_EQ(arrived.actors.size(), wire::kMaxActorReports);
  EXPECT_EQ(arrived.actors_total, wire::kMaxActorReports + 5);
}

TEST(ConvertTest, LearnerStatusOfUnknownStateIsRefused) {
  wire::LearnerStatus status = ToWire(test::SomeLearnerStatus(3));
  EXPECT_EQ(Complaint(status), "");
  status.state(5);
  EXPECT_EQ(Complaint(status), "state 5 of learner is unknown");
}

TEST(ConvertTest, StatusThatNoActorSendsIsRefused) {
  wire::ActorStatus status = ToWire(SomeStatus(1));
  EXPECT_EQ(Complaint(status), "");
  status.steps_per_second(std::numeric_limits<double>::quiet_NaN());
  EXPECT_NE(Complaint(status), "");
  status.steps_per_second(1);
  status.envs(5000);
  EXPECT_NE(Complaint(status), "");
}

TEST(ConvertTest, TextAndConfigurationBeyondTheirBoundsAreNotSent) {
  RunDescription description = SomeDescription(1, "run");
  description.engine.assign(256, 'x');
  EXPECT_THROW(ToWire(description), Malformed);
  description.engine.assign(255, 'x');
  EXPECT_EQ(FromWire(ToWire(description)), description);
  description.config.assign(65537, 'x');
  EXPECT_THROW(ToWire(description), Malformed);
}

/// The verdict of a filter with these parameters on a payload; std::nullopt if there is no such
/// filter.
std::optional<bool> Passes(const std::vector<std::string>& parameters,
                           std::vector<std::uint8_t> bytes) {
  ActorFilterFactory::ParameterSeq::size_type length = 0;
  eprosima::fastdds::dds::LoanableSequence<const char*> texts(4);
  for (const std::string& parameter : parameters) {
    texts.length(length + 1);
    texts[length++] = parameter.c_str();
  }
  eprosima::fastdds::dds::IContentFilter* filter = nullptr;
  auto* factory = ActorFilterFactory::Get();
  if (factory->create_content_filter("", "", nullptr, "", texts, filter)() != 0) {
    return std::nullopt;
  }
  eprosima::fastrtps::rtps::SerializedPayload_t payload;
  payload.data = bytes.data();
  payload.length = static_cast<std::uint32_t>(bytes.size());
  const bool passes = filter->evaluate(payload, {}, {});
  payload.data = nullptr;  // not the payload's to free
  factory->delete_content_filter("", filter);
  return passes;
}

/// Encapsulation and the three members of every message, the last of which is 0x0102030405060708.
std::vector<std::uint8_t> HeaderBytes(bool little_endian) {
  std::vector<std::uint8_t> bytes(4 + 24, 0);
  bytes[1] = little_endian ? 1 : 0;
  for (std::uint8_t i = 0; i < 8; ++i)
    bytes[20U + (little_endian ? 7U - i : i)] = std::uint8_t(i + 1);
  return bytes;
}

TEST(ActorFilterTest, PassesWhatIsForItsActorInBothByteOrders) {
  const std::string mine = std::to_string(0x0102030405060708);
  for (const bool little_endian : {true, false}) {
    EXPECT_EQ(Passes({mine}, HeaderBytes(little_endian)), true);
    EXPECT_EQ(Passes({"72623859790382855"}, HeaderBytes(little_endian)), false);
  }
}

TEST(ActorFilterTest, PassesWhatDoesNotSayWhomItIsFor) {
  for (const std::size_t length : {0U, 1U, 4U, 27U}) {
    std::vector<std::uint8_t> bytes = HeaderBytes(true);
    bytes.resize(length);
    EXPECT_EQ(Passes({"1"}, bytes), true) << length;
  }
}

TEST(ActorFilterTest, ParametersThatAreNoActorMakeNoFilter) {
  EXPECT_EQ(Passes({}, HeaderBytes(true)), std::nullopt);
  EXPECT_EQ(Passes({"1", "2"}, HeaderBytes(true)), std::nullopt);
  for (const std::string text : {"", "x", "1x", "-1", "18446744073709551616"}) {
    EXPECT_EQ(Passes({text}, HeaderBytes(true)), std::nullopt) << text;
  }
}

TEST(BusOptionsTest, NetworksAreUnderstood) {
  EXPECT_EQ(ParseNetwork("loopback").scope, Network::Scope::kLoopback);
  EXPECT_EQ(ParseNetwork("lan").scope, Network::Scope::kLan);
  const Network peers = ParseNetwork("10.0.0.7,10.0.0.8:7410");
  EXPECT_EQ(peers.scope, Network::Scope::kPeers);
  EXPECT_EQ(peers.peers, (std::vector<Network::Peer>{{"10.0.0.7", 0}, {"10.0.0.8", 7410}}));
}

TEST(BusOptionsTest, NonsenseIsNamed) {
  for (const std::string text : {"", "10.0.0.7:", "10.0.0.7:0", "10.0.0.7:65536", ":7410",
                                 "10.0.0.7,,10.0.0.8", "10.0.0.7:port"}) {
    EXPECT_THROW(ParseNetwork(text), std::invalid_argument) << text;
  }
  EXPECT_THAT([] { ParseNetwork("10.0.0.7,[::1]:7400"); },
              testing::ThrowsMessage<std::invalid_argument>(
                  "network peer '[::1]:7400': IPv6 is not supported: give an IPv4 address or a "
                  "host name"));
  EXPECT_EQ(ParseTransport("tcp"), Transport::kTcp);
  EXPECT_THROW(ParseTransport("tpc"), std::invalid_argument);
  BusOptions options;
  for (const std::string& name : {std::string(), std::string("a b"), std::string("a/b"),
                                  std::string("a*"), std::string(65, 'a')}) {
    options.run_name = name;
    EXPECT_THROW(CheckBusOptions(options), std::invalid_argument) << name;
  }
}

TEST(BusOptionsTest, DiscoveryServersHaveTheUsualPort) {
  EXPECT_TRUE(ParseDiscoveryServers("").empty());
  EXPECT_EQ(ParseDiscoveryServers("10.0.0.7,10.0.0.8:5000"),
            (std::vector<Network::Peer>{{"10.0.0.7", 11811}, {"10.0.0.8", 5000}}));
  for (const std::string text :
       {",", "10.0.0.7:", "10.0.0.7:0", ":11811", "10.0.0.7,,10.0.0.8", "::1", "10.0.0.7,"}) {
    EXPECT_THROW(ParseDiscoveryServers(text), std::invalid_argument) << text;
  }
}

/// The complaint of CheckBusOptions about a combination; empty: none.
std::string Objection(const std::string& transport, const std::string& network,
                      const std::string& servers = "") {
  BusOptions options;
  options.run_name = "run";
  options.transport = ParseTransport(transport);
  options.network = ParseNetwork(network);
  options.discovery_servers = ParseDiscoveryServers(servers);
  try {
    CheckBusOptions(options);
    return "";
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

TEST(BusOptionsTest, WaysThatGoTogetherAreTaken) {
  for (const std::string transport : {"udp", "shm"}) {
    EXPECT_EQ(Objection(transport, "10.0.0.7,10.0.0.8"), "");
    EXPECT_EQ(Objection(transport, "lan", "10.0.0.7"), "");
  }
  EXPECT_EQ(Objection("tcp", "loopback"), "");
  EXPECT_EQ(Objection("tcp", "10.0.0.7:5000"), "");
}

TEST(BusOptionsTest, WaysThatDoNotGoTogetherAreNamedWithTheRemedy) {
  using testing::HasSubstr;
  EXPECT_THAT(Objection("tcp", "lan"), HasSubstr("--network HOST[:PORT]"));
  EXPECT_THAT(Objection("tcp", "10.0.0.7,10.0.0.8"), HasSubstr("names 2"));
  EXPECT_THAT(Objection("tcp", "10.0.0.7", "10.0.0.8"), HasSubstr("leave one of the two out"));
  EXPECT_THAT(Objection("udp", "loopback", "10.0.0.8"), HasSubstr("add --network lan"));
  EXPECT_THAT(Objection("shm", "10.0.0.7", "10.0.0.8"), HasSubstr("give --network lan"));
}

TEST(BusOptionsTest, WhoHearsNoLearnerIsToldWhatToLookAt) {
  using testing::HasSubstr;
  BusOptions options;
  options.domain = 3;
  const std::string here = WhyNoLearner(options, "loopback");
  EXPECT_THAT(here, HasSubstr("domain 3, network loopback. If the learner is on another machine"));
  options.network = ParseNetwork("lan");
  const std::string anywhere = WhyNoLearner(options, "lan");
  EXPECT_THAT(anywhere, HasSubstr("network lan. A run that was started without --network"));
  EXPECT_THAT(anywhere, HasSubstr("on that machine leave --network out"));
}

TEST(BusOptionsTest, TheTcpPortIsTheNumberOfDiscoverysUnlessGiven) {
  BusOptions options;
  options.transport = Transport::kTcp;
  EXPECT_EQ(TcpPort(options), 7410);
  options.domain = 3;
  EXPECT_EQ(TcpPort(options), 7410 + 3 * 250);
  options.network = ParseNetwork("10.0.0.7");
  EXPECT_EQ(TcpPort(options), 7410 + 3 * 250);
  options.network = ParseNetwork("10.0.0.7:5000");
  EXPECT_EQ(TcpPort(options), 5000);
}

}  // namespace
}  // namespace metronome::dds
