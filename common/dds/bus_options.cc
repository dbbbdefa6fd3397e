#include "common/dds/bus_options.h"

#include <fastrtps/utils/IPLocator.h>

#include <algorithm>
#include <charconv>
#include <sstream>
#include <stdexcept>

namespace metronome {
namespace {

constexpr std::size_t kMaxRunName = 64;
constexpr std::uint16_t kDiscoveryServerPort = 11811;  // Fast DDS' default
constexpr std::size_t kMaxDiscoveryServers = 255;      // ids are one byte
constexpr std::uint32_t kMaxDomain = 232;  // DDSI-RTPS 2.2, 9.6.1.1: ports stay below 65536

[[noreturn]] void Reject(const std::string& what, const std::string& text,
                         const std::string& choices) {
  throw std::invalid_argument(what + " '" + text + "': " + choices);
}

std::uint16_t ParsePort(const std::string& digits, const std::string& what,
                        const std::string& peer) {
  unsigned value = 0;
  const char* end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, value);
  if (error != std::errc{} || stop != end || value < 1 || value > 65535) {
    Reject(what, peer, "the port must be a number in 1..65535");
  }
  return static_cast<std::uint16_t>(value);
}

/// @param what  for complaints: "network peer" or "discovery server".
Network::Peer ParsePeer(const std::string& what, const std::string& text) {
  const std::size_t colon = text.find(':');
  const std::string host = text.substr(0, colon);
  Network::Peer peer;
  if (colon != std::string::npos) peer.port = ParsePort(text.substr(colon + 1), what, text);
  if (host.empty()) Reject(what, text, "expected host or host:port");
  const auto found = eprosima::fastrtps::rtps::IPLocator::resolveNameDNS(host);
  if (found.first.empty()) Reject(what, text, "no IPv4 address is known for that host");
  peer.address = *found.first.begin();
  return peer;
}

bool IsRunNameCharacter(char c) {
  // Neither path separators nor the wildcards of DDS partitions.
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '_' || c == '-';
}

void CheckTcp(const Network& network) {
  if (network.scope == Network::Scope::kLan) {
    throw std::invalid_argument(
        "transport tcp finds nobody by multicast, as network lan would have it: name the learner's "
        "machine, to the learner too: --network HOST[:PORT]");
  }
  if (network.scope == Network::Scope::kPeers && network.peers.size() > 1) {
    throw std::invalid_argument(
        "transport tcp joins one machine, the learner's, and network names " +
        std::to_string(network.peers.size()) + ": --network HOST[:PORT]");
  }
}

void CheckDiscoveryServers(const BusOptions& options) {
  if (options.transport == Transport::kTcp) {
    throw std::invalid_argument(
        "a discovery server introduces peers over UDP, and transport is tcp: leave one of the two "
        "out; with tcp, --network HOST[:PORT] alone finds the learner");
  }
  if (options.network.scope == Network::Scope::kLoopback) {
    throw std::invalid_argument(
        "a discovery server introduces peers on other machines, and network loopback keeps to this "
        "one: add --network lan");
  }
  if (options.network.scope == Network::Scope::kPeers) {
    throw std::invalid_argument(
        "peers are found by the discovery server, or by their addresses in network, not by both: "
        "give --network lan with the server, or leave the server out");
  }
  if (options.discovery_servers.size() > kMaxDiscoveryServers) {
    Reject("discovery server", std::to_string(options.discovery_servers.size()) + " of them",
           "there may be " + std::to_string(kMaxDiscoveryServers));
  }
}

// Clients of a Discovery Server in Fast DDS 2.9 match without authentication; TCP was not tried.
void CheckSecurity(const BusOptions& options) {
  if (options.transport == Transport::kTcp || !options.discovery_servers.empty()) {
    throw std::invalid_argument(
        "--security goes with --transport udp or shm and without --discovery-server: name the "
        "learner's address by --network instead");
  }
}

}  // namespace

Transport ParseTransport(const std::string& text) {
  if (text == "udp") return Transport::kUdp;
  if (text == "shm") return Transport::kSharedMemory;
  if (text == "tcp") return Transport::kTcp;
  Reject("transport", text, "expected udp, shm or tcp");
}

Network ParseNetwork(const std::string& text) {
  Network network;
  if (text == "loopback") return network;
  if (text == "lan") {
    network.scope = Network::Scope::kLan;
    return network;
  }
  network.scope = Network::Scope::kPeers;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    network.peers.push_back(ParsePeer("network peer", part));
  }
  if (network.peers.empty()) {
    Reject("network", text, "expected loopback, lan or comma-separated peers host[:port]");
  }
  return network;
}

std::vector<Network::Peer> ParseDiscoveryServers(const std::string& text) {
  std::vector<Network::Peer> servers;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    servers.push_back(ParsePeer("discovery server", part));
    if (servers.back().port == 0) servers.back().port = kDiscoveryServerPort;
  }
  return servers;
}

void CheckBusOptions(const BusOptions& options) {
  const std::string& name = options.run_name;
  if (name.empty() || name.size() > kMaxRunName ||
      !std::all_of(name.begin(), name.end(), IsRunNameCharacter)) {
    Reject("run name", name, "expected 1 to 64 letters, digits, '.', '_' or '-'");
  }
  if (options.domain > kMaxDomain) {
    Reject("domain", std::to_string(options.domain), "expected 0 to 232");
  }
  if (options.network.scope == Network::Scope::kPeers && options.network.peers.empty()) {
    throw std::invalid_argument("network: peers asked for, none given");
  }
  if (options.transport == Transport::kTcp) CheckTcp(options.network);
  if (!options.discovery_servers.empty()) CheckDiscoveryServers(options);
  if (!options.security.empty()) CheckSecurity(options);
}

}  // namespace metronome
