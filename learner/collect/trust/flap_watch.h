#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

#include "learner/collect/trust/newest.h"

namespace metronome::collect::trust {

/// When to trust hosts whose actors come and go.
struct FlapRules {
  std::chrono::milliseconds steady{10'000};  // a shorter stay is a flap
  std::uint32_t allowed = 2;                 // flaps in a row without consequence
  std::chrono::milliseconds first{1000};     // probation after one more; doubles with each
  std::chrono::milliseconds longest{60'000};
  std::size_t hosts = 1024;  // kept in mind; whose last flap is longest ago is forgotten first
};

/// Hosts that flap: whose actors are lost soon after they joined, again and again (a link that
/// fails for seconds, a process that crashes and is restarted). Each loss costs the run what was
/// assigned to that actor, so such a host's actors are on probation when they join: others are
/// preferred. Actors of one host that are lost together have flapped once. A long stay forgives
/// everything, and so does being forgotten among too many flapping hosts: no more than assignments
/// that go to others again hangs on it. Pure logic on given time points; not thread-safe.
class FlapWatch {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  explicit FlapWatch(const FlapRules& rules = {}) : rules_(rules), rows_(rules.hosts) {}

  /// The actor is there; may be told again and again.
  /// @return from when on it is trusted; not after `now` if at once.
  TimePoint Join(std::uint64_t actor_id, const std::string& host, TimePoint now);
  /// The actor is gone; unknown ones are ignored.
  void Lose(std::uint64_t actor_id, TimePoint now);
  /// Flaps of the host in a row.
  [[nodiscard]] std::uint32_t FlapsOf(const std::string& host) const;

 private:
  struct Stay {
    std::string host;
    TimePoint since;
    TimePoint trusted_from;
  };
  struct Row {
    std::uint32_t flaps = 0;
    TimePoint last;
  };
  [[nodiscard]] std::chrono::milliseconds Probation(std::uint32_t flaps) const;

  FlapRules rules_;
  std::map<std::uint64_t, Stay> stays_;  // of the actors that are there
  Newest<std::string, Row> rows_;        // of hosts whose last stay was short
};

}  // namespace metronome::collect::trust
