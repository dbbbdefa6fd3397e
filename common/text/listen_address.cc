#include "common/text/listen_address.h"

#include <arpa/inet.h>

#include <stdexcept>

#include "common/text/host_port.h"
#include "common/text/number_text.h"

namespace metronome::text {

ListenAddress ParseListenAddress(const std::string& text) {
  if (IsIpv6(text)) {
    throw std::invalid_argument("IPv6 is not supported: must be PORT or HOST:PORT, HOST IPv4");
  }
  const std::size_t colon = text.rfind(':');
  const auto port =
      ParseNumber<std::uint16_t>(text.substr(colon == std::string::npos ? 0 : colon + 1));
  ListenAddress address;
  if (colon != std::string::npos) address.host = text.substr(0, colon);
  in_addr numeric{};
  if (!port || inet_pton(AF_INET, address.host.c_str(), &numeric) != 1) {
    throw std::invalid_argument(
        "must be PORT or HOST:PORT, a port from 0 to 65535 and a numeric IPv4 address");
  }
  address.port = *port;
  return address;
}

}  // namespace metronome::text
