#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace metronome {

enum class Transport { kUdp, kSharedMemory, kTcp };

/// Where participants of a run look for each other.
struct Network {
  enum class Scope {
    kLoopback,  // 127.0.0.1 alone, discovery too: nothing leaves this machine
    kLan,       // all interfaces, discovery by multicast, or by Discovery Servers
    kPeers,     // all interfaces, discovery by unicast to the peers (and to this machine)
  };
  struct Peer {
    std::string address;     // IPv4, numeric
    std::uint16_t port = 0;  // of its discovery traffic; 0: the well-known ports of the domain
                             // (of TCP and of Discovery Servers: the one default port)
    bool operator==(const Peer&) const = default;
  };
  Scope scope = Scope::kLoopback;
  std::vector<Peer> peers;  // of kPeers, at least one
};

/// @param text  "udp", "shm" or "tcp".
/// @throws std::invalid_argument that names the text and the choices.
Transport ParseTransport(const std::string& text);

/// @param text  "loopback", "lan" or comma-separated peers "host[:port]"; host names are looked up
///              (which may block as long as the resolver does).
/// @throws std::invalid_argument that names the part that is not understood or not found.
Network ParseNetwork(const std::string& text);

/// @param text  "host[:port]", comma-separated; the one at place N is the server started with id N.
///              Empty: none. Port 11811 where none is given. Names are looked up as by
///              ParseNetwork.
/// @throws std::invalid_argument that names the part that is not understood or not found.
std::vector<Network::Peer> ParseDiscoveryServers(const std::string& text);

/// How to join a run on the wire.
struct BusOptions {
  std::string run_name;      // the DDS partition: 1..64 of letters, digits, '.', '_' and '-'
  std::uint32_t domain = 0;  // 0..232
  Transport transport = Transport::kUdp;
  Network network;  // of kTcp: loopback, or one peer, which is the learner's machine
  std::vector<Network::Peer> discovery_servers;  // they introduce peers to each other; kLan only
  /// Folder of an identity that deploy/security made; empty: neither encrypted nor authenticated.
  std::string security;
  /// How long the learner's destructor waits for the last description to be acknowledged.
  std::chrono::milliseconds close_timeout{2000};
};

/// @throws std::invalid_argument that names the first field out of range, or options that do not go
///         together and the remedy.
void CheckBusOptions(const BusOptions& options);

/// Advice for people when no learner of the run is heard.
/// @param network  as typed; see ParseNetwork.
std::string WhyNoLearner(const BusOptions& options, const std::string& network);

}  // namespace metronome
