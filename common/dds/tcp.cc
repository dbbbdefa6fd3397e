#include "common/dds/tcp.h"

#include <arpa/inet.h>
#include <fastdds/rtps/transport/TCPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <memory>
#include <random>
#include <string>

#include "common/dds/participant_qos.h"

namespace metronome::dds {
namespace {

namespace fdds = eprosima::fastdds::dds;
namespace fdds_rtps = eprosima::fastdds::rtps;
namespace rtps = eprosima::fastrtps::rtps;

constexpr const char* kAnyAddress = "0.0.0.0";
constexpr const char* kNoAddress = "0.0.0.1";

std::string LearnerAddress(const Network& network) {
  return network.scope == Network::Scope::kPeers ? network.peers.front().address : kLoopbackAddress;
}

/// This machine's address on the way to `address`; "0.0.0.0" while there is no way.
std::string AddressTowards(const std::string& address) {
  sockaddr_in end{};
  end.sin_family = AF_INET;
  end.sin_port = htons(9);  // connecting a UDP socket looks the route up and sends nothing
  if (inet_pton(AF_INET, address.c_str(), &end.sin_addr) != 1) return kAnyAddress;
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return kAnyAddress;
  socklen_t size = sizeof end;
  std::array<char, INET_ADDRSTRLEN> text{};
  const bool found = connect(probe, reinterpret_cast<const sockaddr*>(&end), size) == 0 &&
                     getsockname(probe, reinterpret_cast<sockaddr*>(&end), &size) == 0 &&
                     inet_ntop(AF_INET, &end.sin_addr, text.data(), text.size()) != nullptr;
  close(probe);
  return found ? text.data() : kAnyAddress;
}

/// A participant's "public address" goes into all its locators, and the learner knows connections
/// by them. Those who connect take one that is random and leads nowhere (RFC 6890: 0.0.0.0/8 is
/// this host on this network): equal addresses behind two translators and equal process ids in two
/// containers stay apart, a participant is not taken for the one that it replaces, and what is left
/// to send when a connection is gone has no place to go to.
std::string NowhereAddress() {
  std::random_device device;
  const std::uint32_t bits = device() | 1U;
  return "0." + std::to_string((bits >> 16) & 0xFF) + "." + std::to_string((bits >> 8) & 0xFF) +
         "." + std::to_string(bits & 0xFF);
}

rtps::Locator_t TcpLocator(const std::string& address, std::uint16_t port,
                           std::uint16_t logical_port) {
  rtps::Locator_t locator;
  locator.kind = LOCATOR_KIND_TCPv4;
  rtps::IPLocator::setIPv4(locator, address);
  rtps::IPLocator::setPhysicalPort(locator, port);
  rtps::IPLocator::setLogicalPort(locator, logical_port);
  return locator;
}

/// The learner as those who connect address it, exactly as it announces itself: Fast DDS finds the
/// connection again by that. They go to the "public address"; the address proper is one that no
/// connection has, since the learner (whose own reader hears its own writer) also connects to
/// itself, and Fast DDS 2.9 takes both ends of that for one if they have one locator.
rtps::Locator_t LearnerLocator(const BusOptions& options, std::uint16_t inner_port) {
  auto locator = TcpLocator(kNoAddress, TcpPort(options), inner_port);
  rtps::IPLocator::setWan(locator, LearnerAddress(options.network));
  return locator;
}

}  // namespace

std::uint16_t TcpPort(const BusOptions& options) {
  const auto& network = options.network;
  if (network.scope == Network::Scope::kPeers && network.peers.front().port != 0) {
    return network.peers.front().port;
  }
  return static_cast<std::uint16_t>(rtps::PortParameters().getUnicastPort(options.domain, 0));
}

void AddTcp(const BusOptions& options, bool is_learner, fdds::DomainParticipantQos* qos) {
  auto tcp = std::make_shared<fdds_rtps::TCPv4TransportDescriptor>();
  tcp->sendBufferSize = kSocketBufferBytes;
  tcp->receiveBufferSize = kSocketBufferBytes;
  tcp->enable_tcp_nodelay = true;
  tcp->calculate_crc = false;  // TCP has its own
  tcp->check_crc = false;
  // The port inside a connection, equal for all, and one for discovery and data alike: Fast DDS 2.9
  // asks to open a port and then notes that it did (TCPChannelResource::add_logical_port); if the
  // answer is faster, what is sent there is dropped for ever. The one that an actor wants of the
  // learner is noted before there is a connection.
  const auto inner_port =
      static_cast<std::uint16_t>(rtps::PortParameters().getUnicastPort(options.domain, 0));
  auto& wire = qos->wire_protocol();
  if (is_learner) {
    tcp->add_listener_port(TcpPort(options));
    tcp->set_WAN_address(LearnerAddress(options.network));
    if (options.network.scope == Network::Scope::kLoopback) {
      tcp->interfaceWhiteList.emplace_back(kLoopbackAddress);
    }
    wire.builtin.metatrafficUnicastLocatorList.push_back(LearnerLocator(options, inner_port));
    wire.default_unicast_locator_list.push_back(LearnerLocator(options, inner_port));
  } else {
    tcp->set_WAN_address(NowhereAddress());
    const std::string here = AddressTowards(LearnerAddress(options.network));
    wire.builtin.metatrafficUnicastLocatorList.push_back(TcpLocator(here, 0, inner_port));
    wire.default_unicast_locator_list.push_back(TcpLocator(here, 0, inner_port));
    wire.builtin.initialPeersList.push_back(LearnerLocator(options, inner_port));
  }
  qos->transport().user_transports.push_back(tcp);
}

}  // namespace metronome::dds
