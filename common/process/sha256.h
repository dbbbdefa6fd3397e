#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// SHA-256 (FIPS 180-4), by OpenSSL. Pure functions, thread-safe.
namespace metronome::process {

using Sha256Digest = std::array<std::uint8_t, 32>;

Sha256Digest Sha256(std::string_view bytes);

/// 64 lower-case hexadecimal digits.
std::string Sha256Hex(std::string_view bytes);

/// Over the parameters alone, as little-endian float32 in their order: equal exactly when two
/// networks have equal bits.
std::string WeightsSha256(const std::vector<float>& parameters);

}  // namespace metronome::process
