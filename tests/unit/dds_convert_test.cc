#include <gtest/gtest.h>

#include <limits>

#include "common/dds/bus_options.h"
#include "common/dds/convert.h"
#include "tests/integration/dds_fixture.h"

namespace metronome::dds {
namespace {

using test::SomeDescription;
using test::SomeEpisode;
using test::SomeOrder;
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
  EXPECT_EQ(Complaint(bad), "observation has 428 elements instead of 429");
  bad = good;
  bad.action().push_back(0);
  EXPECT_EQ(Complaint(bad), "action has 41 elements instead of 40");
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

TEST(ConvertTest, EpisodeLongerThanTheTimeLimitIsRefusedBothWays) {
  EXPECT_NO_THROW(ToWire(SomeEpisode(1, 500)));
  EXPECT_THROW(ToWire(SomeEpisode(1, 501)), Malformed);
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

TEST(ConvertTest, OrderOfUnknownKindIsRefused) {
  wire::EpisodeOrder order = ToWire(SomeOrder(1, 2));
  EXPECT_EQ(Complaint(order), "");
  order.kind(2);
  EXPECT_EQ(Complaint(order), "kind 2 of order is unknown");
}

TEST(ConvertTest, StatusThatNoActorSendsIsRefused) {
  wire::ActorStatus status = ToWire(SomeStatus(1));
  EXPECT_EQ(Complaint(status), "");
  status.steps_per_second(std::numeric_limits<double>::quiet_NaN());
  EXPECT_NE(Complaint(status), "");
  status.steps_per_second(1);
  status.slots(5000);
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
  EXPECT_THROW(ParseTransport("tcp"), std::invalid_argument);
  BusOptions options;
  for (const std::string& name : {std::string(), std::string("a b"), std::string("a/b"),
                                  std::string("a*"), std::string(65, 'a')}) {
    options.run_name = name;
    EXPECT_THROW(CheckBusOptions(options), std::invalid_argument) << name;
  }
}

}  // namespace
}  // namespace metronome::dds
