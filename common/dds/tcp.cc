#include "common/dds/tcp.h"

#include <arpa/inet.h>
#include <fastdds/rtps/transport/TCPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "common/dds/participant_qos.h"

namespace metronome::dds {
namespace {

namespace fdds = eprosima::fastdds::dds;
namespace fdds_rtps = eprosima::fastdds::rtps;
namespace rtps = eprosima::fastrtps::rtps;

constexpr const char* kAnyAddress = "0.0.0.0";
constexpr const char* kNoAddress = "0.0.0.1";
constexpr std::chrono::milliseconds kMuteFor{300};
constexpr std::chrono::milliseconds kMutePoll{5};
constexpr std::chrono::seconds kEndFor{5};
constexpr std::chrono::milliseconds kEndPoll{2};

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

std::optional<int> NumberOf(const std::filesystem::path& descriptor) {
  const std::string name = descriptor.filename();
  int number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  return error == std::errc{} ? std::optional(number) : std::nullopt;
}

/// This process's open descriptors; none if there is no descriptor left to list them by.
std::vector<int> Descriptors() {
  std::vector<int> descriptors;
  std::error_code error;  // destructors list them too, and must not throw
  for (std::filesystem::directory_iterator entry("/proc/self/fd", error), end; entry != end;
       entry.increment(error)) {
    if (const auto descriptor = NumberOf(entry->path())) descriptors.push_back(*descriptor);
  }
  return descriptors;
}

/// @param end  getsockname: our end's port; getpeername: the other's. @return std::nullopt if the
/// descriptor is no IPv4 socket or has no such end.
std::optional<std::uint16_t> PortOf(int descriptor, decltype(&getsockname) end) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  if (end(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0 ||
      address.sin_family != AF_INET) {
    return std::nullopt;
  }
  return ntohs(address.sin_port);
}

bool ListensOn(int descriptor, std::uint16_t port) {
  int listens = 0;
  socklen_t size = sizeof listens;
  return getsockopt(descriptor, SOL_SOCKET, SO_ACCEPTCONN, &listens, &size) == 0 && listens != 0 &&
         PortOf(descriptor, getsockname) == port;
}

bool IsConnectedTo(int descriptor, std::uint16_t port) {
  return PortOf(descriptor, getpeername) == port;
}

/// The socket that a descriptor stands for, under a name that no other open one has; std::nullopt
/// if it was closed meanwhile.
std::optional<std::string> SocketOf(int descriptor) {
  std::error_code error;
  const auto target =
      std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(descriptor), error);
  return error ? std::nullopt : std::optional(target.string());
}

/// Whether something came in answer to our first message and we said nothing since.
bool IsMute(int descriptor) {
  tcp_info info{};
  socklen_t size = sizeof info;
  return getsockopt(descriptor, IPPROTO_TCP, TCP_INFO, &info, &size) == 0 &&
         info.tcpi_bytes_received > 0 && info.tcpi_data_segs_out <= 1;
}

/// Whether it stays mute for longer than Fast DDS takes to go on.
bool StaysMute(int descriptor) {
  const auto deadline = std::chrono::steady_clock::now() + kMuteFor;
  while (IsMute(descriptor)) {
    if (std::chrono::steady_clock::now() >= deadline) return true;
    std::this_thread::sleep_for(kMutePoll);
  }
  return false;
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

void EndSilentConnections(std::uint16_t port) {
  bool found = false;
  for (const int descriptor : Descriptors()) {
    if (!ListensOn(descriptor, port)) continue;
    found = true;
    // Connections inherit it from the socket that accepts them.
    const std::uint32_t milliseconds = kLeaseMilliseconds;
    if (setsockopt(descriptor, IPPROTO_TCP, TCP_USER_TIMEOUT, &milliseconds, sizeof milliseconds) !=
        0) {
      throw std::runtime_error("TCP port " + std::to_string(port) +
                               ": no time-out can be set for its connections");
    }
  }
  if (found) return;
  throw std::runtime_error(
      "TCP port " + std::to_string(port) +
      " cannot be listened on: another learner of this machine and domain may have it; choose "
      "another, for the actors too: --network HOST:PORT");
}

void CutMuteConnections(std::uint16_t port) {
  for (const int descriptor : Descriptors()) {
    if (IsConnectedTo(descriptor, port) && StaysMute(descriptor)) shutdown(descriptor, SHUT_RDWR);
  }
}

void EndConnections(std::uint16_t port) {
  for (const int descriptor : Descriptors()) {
    if (ListensOn(descriptor, port)) shutdown(descriptor, SHUT_RDWR);  // nobody else comes in
  }
  std::vector<std::pair<int, std::string>> ended;
  for (const int descriptor : Descriptors()) {
    const bool is_accepted =
        PortOf(descriptor, getsockname) == port && PortOf(descriptor, getpeername);
    if (!is_accepted && !IsConnectedTo(descriptor, port)) continue;
    if (const auto socket = SocketOf(descriptor)) ended.emplace_back(descriptor, *socket);
    shutdown(descriptor, SHUT_RDWR);
  }
  // The thread that reads a socket closes it when it is done with what came last.
  const auto is_open = [](const auto& socket) { return SocketOf(socket.first) == socket.second; };
  const auto deadline = std::chrono::steady_clock::now() + kEndFor;
  while (std::any_of(ended.begin(), ended.end(), is_open) &&
         std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(kEndPoll);
  }
}

}  // namespace metronome::dds
