#pragma once

#include <cstdint>
#include <string>

#include "common/checkpoint/checkpoint.h"
#include "common/process/sha256.h"

namespace metronome::fuzz {

/// A checkpoint file that is whole, whatever its payload says (common/README.md, "Checkpoints").
inline std::string Framed(const std::string& payload) {
  const auto raw = [](auto value) {
    return std::string(reinterpret_cast<const char*>(&value), sizeof value);
  };
  const std::string head = "METRCKPT" + raw(std::uint32_t{checkpoint::kCheckpointFormat}) +
                           raw(static_cast<std::uint64_t>(payload.size()));
  const process::Sha256Digest digest = process::Sha256(head + payload);
  return head + std::string(digest.begin(), digest.end()) + payload;
}

}  // namespace metronome::fuzz
