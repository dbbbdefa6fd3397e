#pragma once

#include <cstdint>
#include <string>

#include "common/messages/messages.h"

namespace metronome::collect {

/// A build as logs and refusals show it: actors may send more than anybody reads.
std::string ShownBuild(const std::string& build);

/// Decides which actors may play for a run. Pure logic; not thread-safe.
class Admission {
 public:
  enum class Verdict {
    kAdmit,
    kWait,    // it has not heard of this learner yet: another status will come
    kRefuse,  // `reason` says why, naming both sides; long builds are cut short
  };
  struct Decision {
    Verdict verdict = Verdict::kWait;
    std::string reason;
  };

  /// @param description  what this learner publishes.
  /// @param digest       of the run's canonical episode, empty before any actor brought one.
  Admission(const RunDescription& description, std::string digest);

  /// The first admitted actor sets the run's digest; the others must equal it. A digest that
  /// completes that of an older build takes its place.
  Decision Judge(const ActorStatus& status);

  /// Empty until an actor was admitted.
  [[nodiscard]] const std::string& digest() const { return digest_; }

 private:
  [[nodiscard]] std::string DigestComplaint(const ActorStatus& status) const;

  std::uint64_t incarnation_;
  std::string engine_;
  std::string digest_;
  std::string digest_from_;  // who brought the digest
};

}  // namespace metronome::collect
