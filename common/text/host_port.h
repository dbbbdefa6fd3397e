#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace metronome::text {

/// "HOST[:PORT]" taken apart; nothing is looked up.
struct HostPort {
  std::string host;        // an IPv4 address or a name
  std::uint16_t port = 0;  // 0: not given
};

/// @param text  "HOST[:PORT]", separated by commas; at least one.
/// @throws std::invalid_argument that quotes the part that is wrong and says why.
std::vector<HostPort> ParseHostPorts(const std::string& text);

/// @return true for an IPv6 address, which nothing here supports; a zone, brackets and a port may
/// be with it.
bool IsIpv6(const std::string& text);

}  // namespace metronome::text
