#include "common/dds/peer_hosts.h"

#include <fastrtps/utils/IPLocator.h>
#include <gtest/gtest.h>

#include <fastdds/rtps/attributes/RTPSParticipantAllocationAttributes.hpp>
#include <string>
#include <vector>

namespace metronome::dds {
namespace {

namespace rtps = eprosima::fastrtps::rtps;

/// A participant as discovery tells of it.
class Peer {
 public:
  Peer(std::uint32_t id, const std::vector<std::string>& addresses)
      : proxy_(rtps::RTPSParticipantAllocationAttributes()) {
    for (std::size_t i = 0; i < 4; ++i) {
      proxy_.m_guid.guidPrefix.value[8 + i] = static_cast<rtps::octet>(id >> (8 * i));
    }
    for (std::size_t i = 0; i < 6; ++i) {
      proxy_.m_guid.guidPrefix.value[i] = static_cast<rtps::octet>(0xA0 + i);
    }
    for (const std::string& address : addresses) {
      rtps::Locator_t locator;
      locator.kind = LOCATOR_KIND_UDPv4;
      rtps::IPLocator::setIPv4(locator, address);
      proxy_.default_locators.add_unicast_locator(locator);
    }
  }

  void Is(workarounds::Discovered::DISCOVERY_STATUS status, PeerHosts& hosts) const {
    workarounds::Discovered discovered(proxy_);
    discovered.status = status;
    hosts.Note(discovered);
  }

  ParticipantKey key() const {
    ParticipantKey key{};
    for (std::size_t i = 0; i < key.size(); ++i) key[i] = proxy_.m_guid.guidPrefix.value[i];
    return key;
  }

 private:
  rtps::ParticipantProxyData proxy_;
};

TEST(PeerHostsTest, AHostIsAllAddressesThatDiscoveryFirstTold) {
  PeerHosts hosts(false);
  const Peer one(1, {"172.17.0.1", "10.0.0.5"}), same(2, {"10.0.0.5", "172.17.0.1"});
  const Peer other(3, {"10.0.0.6", "172.17.0.1"}), changed(1, {"10.0.0.9"});
  for (const Peer* peer : {&one, &same, &other})
    peer->Is(workarounds::Discovered::DISCOVERED_PARTICIPANT, hosts);
  EXPECT_EQ(hosts.HostOf(one.key()), "10.0.0.5+172.17.0.1");
  EXPECT_EQ(hosts.HostOf(same.key()), hosts.HostOf(one.key()));
  EXPECT_EQ(hosts.HostOf(other.key()), "10.0.0.6+172.17.0.1");
  changed.Is(workarounds::Discovered::CHANGED_QOS_PARTICIPANT, hosts);
  EXPECT_EQ(hosts.HostOf(one.key()), "10.0.0.5+172.17.0.1");
  EXPECT_EQ(hosts.HostOf(Peer(4, {}).key()), "unknown address");
}

TEST(PeerHostsTest, OfThoseWhoAreGoneOnlyTheLastAreRemembered) {
  PeerHosts hosts(false);
  const Peer first(0, {"10.0.0.1"});
  for (std::uint32_t id = 0; id < 1100; ++id) {
    const Peer peer(id, {"10.0.0.1"});
    peer.Is(workarounds::Discovered::DISCOVERED_PARTICIPANT, hosts);
    peer.Is(workarounds::Discovered::REMOVED_PARTICIPANT, hosts);
    if (id > 0) continue;
    EXPECT_EQ(hosts.HostOf(first.key()), "10.0.0.1") << "its last words may come";
  }
  EXPECT_EQ(hosts.HostOf(first.key()), "unknown address");
  EXPECT_EQ(hosts.HostOf(Peer(1099, {}).key()), "10.0.0.1");
}

TEST(PeerHostsTest, WithSecurityAHostIsWhatTheGuidSaysOfTheCertificate) {
  PeerHosts hosts(true);
  const Peer one(1, {"10.0.0.5"}), same(2, {"10.0.0.6"});
  one.Is(workarounds::Discovered::DISCOVERED_PARTICIPANT, hosts);
  EXPECT_EQ(hosts.HostOf(one.key()), "certificate a0a1a2a3a4a5");
  EXPECT_EQ(hosts.HostOf(same.key()), hosts.HostOf(one.key()));
}

}  // namespace
}  // namespace metronome::dds
