#include "common/process/sha256.h"

#include <openssl/evp.h>

#include <bit>
#include <stdexcept>

namespace metronome::process {

static_assert(std::endian::native == std::endian::little, "float32 bytes are hashed as they lie");

Sha256Digest Sha256(std::string_view bytes) {
  Sha256Digest digest{};
  unsigned size = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1 ||
      size != digest.size()) {
    throw std::runtime_error("OpenSSL offers no SHA-256");
  }
  return digest;
}

std::string Sha256Hex(std::string_view bytes) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string hex;
  for (const std::uint8_t byte : Sha256(bytes)) {
    hex += kDigits[byte >> 4];
    hex += kDigits[byte & 15];
  }
  return hex;
}

std::string WeightsSha256(const std::vector<float>& parameters) {
  return Sha256Hex(
      {reinterpret_cast<const char*>(parameters.data()), parameters.size() * sizeof(float)});
}

}  // namespace metronome::process
