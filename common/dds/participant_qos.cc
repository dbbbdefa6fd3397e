#include "common/dds/participant_qos.h"

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include <memory>

#include "common/dds/security/security.h"
#include "common/dds/shared_memory.h"
#include "common/dds/tcp.h"
#include "common/dds/workarounds/shared_memory_files.h"

namespace metronome::dds {
namespace {

namespace fdds = eprosima::fastdds::dds;
namespace fdds_rtps = eprosima::fastdds::rtps;
namespace rtps = eprosima::fastrtps::rtps;

constexpr const char* kDiscoveryGroup = "239.255.0.1";  // DDSI-RTPS 2.2, 9.6.1.4.1
// On a network a datagram is one packet (Ethernet's 1500 bytes, less what tunnels take). Of the 64
// KB of loopback IP makes 45 fragments, and each that is lost costs them all: at 5 % loss one
// datagram of ten arrives, at 20 % none ever does.
constexpr std::uint32_t kDatagramBytes = 1400;
// Fast DDS does not cut the messages of its handshake, which carry certificate and permissions: 4.6
// KB, 5.9 KB with the longest names, more on hosts of many addresses. Five packets a datagram then.
constexpr std::uint32_t kSecureDatagramBytes = 7392;
// Participants a machine that unicast discovery without a port reaches.
constexpr std::uint32_t kParticipantsPerPeer = 16;
// Actors take the ports behind those: what is sent to the well-known ones finds learners alone.
constexpr std::uint32_t kFirstActor = kParticipantsPerPeer;

rtps::Locator_t UdpLocator(const std::string& address, std::uint32_t port) {
  rtps::Locator_t locator;
  locator.kind = LOCATOR_KIND_UDPv4;
  rtps::IPLocator::setIPv4(locator, address);
  locator.port = port;
  return locator;
}

std::shared_ptr<fdds_rtps::TransportDescriptorInterface> UdpTransport(const BusOptions& options) {
  auto udp = std::make_shared<fdds_rtps::UDPv4TransportDescriptor>();
  udp->sendBufferSize = kSocketBufferBytes;
  udp->receiveBufferSize = kSocketBufferBytes;
  udp->maxInitialPeersRange = kParticipantsPerPeer;
  if (options.network.scope == Network::Scope::kLoopback) {
    udp->interfaceWhiteList.emplace_back(kLoopbackAddress);
  } else {
    udp->maxMessageSize = options.security.empty() ? kDatagramBytes : kSecureDatagramBytes;
  }
  return udp;
}

/// The participants that a peer's address may mean. Actors announce themselves to learners; a
/// learner that is told of hosts by name also looks for actors there.
void AddPeer(const Network::Peer& peer, std::uint32_t first_actor_port, bool is_actor,
             rtps::LocatorList_t* peers) {
  peers->push_back(UdpLocator(peer.address, peer.port));
  if (is_actor || peer.port != 0) return;
  for (std::uint32_t i = 0; i < kParticipantsPerPeer; ++i) {
    peers->push_back(UdpLocator(peer.address, first_actor_port + 2 * i));
  }
}

void SetLease(rtps::BuiltinAttributes* builtin) {
  builtin->discovery_config.leaseDuration = kLease;
  builtin->discovery_config.leaseDuration_announcementperiod = kAnnouncement;
}

/// Servers tell a participant of those alone whose topics it shares: with them too, discovery is a
/// star.
void SetDiscoveryServers(const BusOptions& options, fdds::WireProtocolConfigQos* wire) {
  auto& config = wire->builtin.discovery_config;
  config.discoveryProtocol = rtps::DiscoveryProtocol_t::CLIENT;
  int id = 0;
  for (const Network::Peer& peer : options.discovery_servers) {
    rtps::RemoteServerAttributes server;
    rtps::get_server_client_default_guidPrefix(id++, server.guidPrefix);
    server.metatrafficUnicastLocatorList.push_back(UdpLocator(peer.address, peer.port));
    config.m_DiscoveryServers.push_back(server);
  }
}

/// Discovery is a star. All participants that hear each other exchange their endpoints, announce
/// themselves to each other twice a second and once more whenever another appears: with N actors
/// that is N^3 messages at the start. So actors speak to the multicast group and to the learners'
/// well-known ports, but hear only who answers them: the learners.
void SetDiscovery(const BusOptions& options, bool is_actor, fdds::WireProtocolConfigQos* wire) {
  rtps::BuiltinAttributes& builtin = wire->builtin;
  const std::uint32_t first_actor_port = wire->port.getUnicastPort(options.domain, kFirstActor);
  // Fast DDS takes the next free port of those that follow; 0 means the first learner's.
  builtin.metatrafficUnicastLocatorList.push_back(
      UdpLocator("0.0.0.0", is_actor ? first_actor_port : 0));
  if (!options.discovery_servers.empty()) {
    SetDiscoveryServers(options, wire);
    return;
  }
  // This machine by unicast always: not every kernel's loopback carries multicast.
  builtin.initialPeersList.push_back(UdpLocator(kLoopbackAddress, 0));
  if (options.network.scope == Network::Scope::kPeers) {
    for (const Network::Peer& peer : options.network.peers) {
      AddPeer(peer, first_actor_port, is_actor, &builtin.initialPeersList);
    }
    return;
  }
  const auto group = UdpLocator(kDiscoveryGroup, wire->port.getMulticastPort(options.domain));
  if (!is_actor) builtin.metatrafficMulticastLocatorList.push_back(group);
  builtin.initialPeersList.push_back(group);
}

/// Samples between processes of one machine go through memory; discovery stays on UDP, which
/// survives kills and respawns.
void AddSharedMemory(std::uint32_t segment_bytes, fdds::DomainParticipantQos* qos) {
  auto memory = std::make_shared<fdds_rtps::SharedMemTransportDescriptor>();
  memory->segment_size(segment_bytes);
  qos->transport().user_transports.push_back(memory);
  rtps::Locator_t locator;
  locator.kind = LOCATOR_KIND_SHM;
  locator.port = workarounds::SharedMemoryPort();
  qos->wire_protocol().default_unicast_locator_list.push_back(locator);
  qos->wire_protocol().default_unicast_locator_list.push_back(UdpLocator("0.0.0.0", 0));
}

}  // namespace

bool FindsLearnersAlone(const std::string& role) {
  return role == kActorRole || role == kObserverRole;
}

fdds::DomainParticipantQos ParticipantQos(const BusOptions& options, const std::string& role) {
  fdds::DomainParticipantQos qos = fdds::PARTICIPANT_QOS_DEFAULT;
  qos.name("metronome-" + role + " " + options.run_name);
  if (!options.security.empty()) security::AddSecurity(options.security, &qos.properties());
  qos.transport().use_builtin_transports = false;
  qos.transport().send_socket_buffer_size = kSocketBufferBytes;
  qos.transport().listen_socket_buffer_size = kSocketBufferBytes;
  SetLease(&qos.wire_protocol().builtin);
  if (options.transport == Transport::kTcp) {
    AddTcp(options, !FindsLearnersAlone(role), &qos);
    return qos;
  }
  qos.transport().user_transports.push_back(UdpTransport(options));
  SetDiscovery(options, FindsLearnersAlone(role), &qos.wire_protocol());
  if (options.transport == Transport::kSharedMemory) AddSharedMemory(SegmentBytes(role), &qos);
  return qos;
}

}  // namespace metronome::dds
