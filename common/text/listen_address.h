#pragma once

#include <cstdint>
#include <string>

namespace metronome::text {

/// Where a server of this process listens (TCP).
struct ListenAddress {
  std::string host = "127.0.0.1";  // IPv4, numeric; 0.0.0.0: all interfaces
  std::uint16_t port = 0;          // 0: any free one

  [[nodiscard]] std::string Text() const { return host + ":" + std::to_string(port); }
};

/// @param text  "PORT", on 127.0.0.1, or "HOST:PORT" with a numeric IPv4 address.
/// @throws std::invalid_argument that says what it must be.
ListenAddress ParseListenAddress(const std::string& text);

}  // namespace metronome::text
