#include "common/listen_address.h"

#include <arpa/inet.h>

#include <stdexcept>

#include "common/number_text.h"

namespace metronome {

ListenAddress ParseListenAddress(const std::string& text) {
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

}  // namespace metronome
