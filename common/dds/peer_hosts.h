#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <string>

#include "common/dds/workarounds/lease_race_guard.h"
#include "common/process/mutex.h"

namespace metronome::dds {

/// The participant part of a GUID: equal for all endpoints of one process.
using ParticipantKey = std::array<std::uint8_t, 12>;

/// The hosts of other participants, as far as Fast DDS 2.9 vouches for them. Thread-safe.
///
/// With security: "certificate " and 47 bits of the SHA-256 of the subject of the participant's
/// certificate, in hex. Fast DDS does not show a peer's certificate, but an authenticated
/// participant's GUID begins with these bits (DDS-Security 1.1, 9.3.2.1), which the handshake
/// checks. Without: the IPv4 addresses with which discovery announced it first, all of them, sorted
/// ("10.0.0.5+172.17.0.1"); of a participant on this machine Fast DDS makes loopback's. A program
/// that was changed can announce others.
class PeerHosts {
 public:
  explicit PeerHosts(bool security) : security_(security) {}

  /// A participant was discovered, changed or is gone.
  void Note(const workarounds::Discovered& discovered);
  /// @return "unknown address" of one that discovery did not tell of, or that is long gone.
  [[nodiscard]] std::string HostOf(const ParticipantKey& participant) const;

 private:
  // Samples of the last ones may be read after they are gone.
  static constexpr std::size_t kGoneKept = 1024;

  const bool security_;
  mutable process::Mutex mutex_;
  std::map<ParticipantKey, std::string> hosts_ METRONOME_GUARDED_BY(mutex_);
  std::deque<ParticipantKey> gone_ METRONOME_GUARDED_BY(mutex_);  // oldest first; still in hosts_
};

}  // namespace metronome::dds
