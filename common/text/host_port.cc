#include "common/text/host_port.h"

#include <arpa/inet.h>

#include <algorithm>
#include <stdexcept>

#include "common/text/number_text.h"

namespace metronome::text {
namespace {

bool IsHostCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '-' || c == '_';
}

/// @throws std::invalid_argument.
std::uint16_t ParsePort(const std::string& digits) {
  const auto port = ParseNumber<std::uint16_t>(digits);
  if (!port || *port == 0) {
    throw std::invalid_argument("the port must be a number in 1..65535");
  }
  return *port;
}

/// @throws std::invalid_argument that says why, without the text itself.
HostPort ParseOne(const std::string& text) {
  if (text.empty()) {
    throw std::invalid_argument("nothing stands here: expected HOST[:PORT], separated by a comma");
  }
  if (text.find("://") != std::string::npos) {
    throw std::invalid_argument("is a URL: give HOST[:PORT] alone");
  }
  if (IsIpv6(text)) {
    throw std::invalid_argument("IPv6 is not supported: give an IPv4 address or a host name");
  }
  if (text == "lan" || text == "loopback") {
    throw std::invalid_argument("stands alone, or hosts do");
  }
  const std::size_t colon = text.find(':');
  HostPort parsed{text.substr(0, colon)};
  if (parsed.host.empty() ||
      !std::all_of(parsed.host.begin(), parsed.host.end(), IsHostCharacter)) {
    throw std::invalid_argument(
        "expected HOST[:PORT], an IPv4 address or a host name of letters, digits, '.', '-' and "
        "'_', without spaces");
  }
  if (colon != std::string::npos) parsed.port = ParsePort(text.substr(colon + 1));
  return parsed;
}

}  // namespace

std::vector<HostPort> ParseHostPorts(const std::string& text) {
  std::vector<HostPort> parsed;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    try {
      parsed.push_back(ParseOne(part));
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument("'" + part + "': " + error.what());
    }
    begin = end + 1;
  }
  return parsed;
}

bool IsIpv6(const std::string& text) {
  const bool is_bracketed = text.starts_with('[');
  std::string address = is_bracketed ? text.substr(1, text.find(']') - 1) : text;
  address = address.substr(0, address.find('%'));
  in6_addr numeric{};
  return inet_pton(AF_INET6, address.c_str(), &numeric) == 1;
}

}  // namespace metronome::text
