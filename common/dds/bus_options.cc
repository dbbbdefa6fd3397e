#include "common/dds/bus_options.h"

#include <fastrtps/utils/IPLocator.h>

#include <algorithm>
#include <charconv>
#include <sstream>
#include <stdexcept>

namespace metronome {
namespace {

constexpr std::size_t kMaxRunName = 64;
constexpr std::uint32_t kMaxDomain = 232;  // DDSI-RTPS 2.2, 9.6.1.1: ports stay below 65536

[[noreturn]] void Reject(const std::string& what, const std::string& text,
                         const std::string& choices) {
  throw std::invalid_argument(what + " '" + text + "': " + choices);
}

std::uint16_t ParsePort(const std::string& digits, const std::string& peer) {
  unsigned value = 0;
  const char* end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, value);
  if (error != std::errc{} || stop != end || value < 1 || value > 65535) {
    Reject("network peer", peer, "the port must be a number in 1..65535");
  }
  return static_cast<std::uint16_t>(value);
}

Network::Peer ParsePeer(const std::string& text) {
  const std::size_t colon = text.find(':');
  const std::string host = text.substr(0, colon);
  Network::Peer peer;
  if (colon != std::string::npos) peer.port = ParsePort(text.substr(colon + 1), text);
  if (host.empty()) Reject("network peer", text, "expected host or host:port");
  const auto found = eprosima::fastrtps::rtps::IPLocator::resolveNameDNS(host);
  if (found.first.empty()) Reject("network peer", text, "no IPv4 address is known for that host");
  peer.address = *found.first.begin();
  return peer;
}

bool IsRunNameCharacter(char c) {
  // Neither path separators nor the wildcards of DDS partitions.
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '_' || c == '-';
}

}  // namespace

Transport ParseTransport(const std::string& text) {
  if (text == "udp") return Transport::kUdp;
  if (text == "shm") return Transport::kSharedMemory;
  Reject("transport", text, "expected udp or shm");
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
  for (std::string part; std::getline(parts, part, ',');) network.peers.push_back(ParsePeer(part));
  if (network.peers.empty()) {
    Reject("network", text, "expected loopback, lan or comma-separated peers host[:port]");
  }
  return network;
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
}

}  // namespace metronome
