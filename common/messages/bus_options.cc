#include "common/messages/bus_options.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <memory>
#include <set>
#include <stdexcept>

#include "common/text/host_port.h"

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

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

Addresses Resolve(const std::string& host) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;  // each address once
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), nullptr, &hints, &found) != 0) found = nullptr;
  return {found, freeaddrinfo};
}

/// In the order of their text, so that each lookup of a host gives the same one.
std::set<std::string> Ipv4Addresses(const addrinfo* found) {
  std::set<std::string> addresses;
  for (; found != nullptr; found = found->ai_next) {
    if (found->ai_family != AF_INET) continue;
    const auto& end = *reinterpret_cast<const sockaddr_in*>(found->ai_addr);
    std::array<char, INET_ADDRSTRLEN> text{};
    addresses.insert(inet_ntop(AF_INET, &end.sin_addr, text.data(), text.size()));
  }
  return addresses;
}

/// @param what  for complaints: "network peer" or "discovery server".
std::string Ipv4Of(const std::string& what, const std::string& host) {
  const Addresses found = Resolve(host);
  const std::set<std::string> v4 = Ipv4Addresses(found.get());
  if (!v4.empty()) return *v4.begin();
  if (!found) Reject(what, host, "no IPv4 address is known for that host");
  Reject(what, host,
         "that host has IPv6 addresses alone, and IPv6 is not supported: give an IPv4 address");
}

/// @param what  as of Ipv4Of.
std::vector<Network::Peer> ParsePeers(const std::string& what, const std::string& text) {
  std::vector<Network::Peer> peers;
  try {
    for (const text::HostPort& one : text::ParseHostPorts(text))
      peers.push_back({one.host, one.port});
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(what + " " + error.what());
  }
  for (Network::Peer& peer : peers) peer.address = Ipv4Of(what, peer.address);
  return peers;
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
  network.peers = ParsePeers("network peer", text);
  return network;
}

std::vector<Network::Peer> ParseDiscoveryServers(const std::string& text) {
  if (text.empty()) return {};
  auto servers = ParsePeers("discovery server", text);
  for (Network::Peer& server : servers) {
    if (server.port == 0) server.port = kDiscoveryServerPort;
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

std::string WhyNoLearner(const BusOptions& options, const std::string& network) {
  std::string text = "domain " + std::to_string(options.domain) + ", network " + network + ". ";
  if (options.network.scope == Network::Scope::kLoopback) {
    text += "If the learner is on another machine, give --network here as it was given there";
  } else {
    text +=
        "A run that was started without --network is open to its own machine alone: on that "
        "machine leave --network out here too; to let others in, stop the run and go on with "
        "--network lan --resume";
  }
  return text +
         ". Otherwise: is the learner running, and were --run, --domain, --transport, --network, "
         "--discovery-server and the authority of --security the same there?";
}

}  // namespace metronome
