#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>

#include "learner/collect/trust/excluded_hosts.h"
#include "learner/collect/trust/flap_watch.h"
#include "learner/collect/trust/newest.h"

namespace metronome::collect::trust {

/// When to trust whom.
struct TrustRules {
  FlapRules flaps;
  // An actor that gave up an assignment is on trial after this, doubled with each further one.
  std::chrono::milliseconds first_rest{1000};
  std::chrono::milliseconds longest_rest{60'000};
  std::uint32_t bad_answers_allowed = 10;  // in a row, by one actor
  std::size_t refused = 4096;              // actors kept in mind
};

/// The four ideas of distrust, in one place; learner/README.md has them in a table.
///
/// | observed                           | of    | follows                            | until | |
/// its actors come and go (flap)      | host  | others are asked first             | a long stay |
/// | gives up an assignment (silence)        | actor | rests, then one assignment as its trial | it
/// brings anything | | bad answers in a row               | actor | refused | it is forgotten    |
/// | differs from other hosts (audit)   | host  | excluded, all its actors refused   | a person
/// says so   |
///
/// Hosts are what the middleware vouches for (ActorStatus::vouched_host). Pure logic on given time
/// points; not thread-safe.
class Trust {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// @param excluded  by earlier starts of the learner: the only distrust that outlives one.
  Trust(const TrustRules& rules, ExcludedHosts excluded);

  /// Of an actor that joins: from when on it is trusted (not after `now` if at once), and how often
  /// in a row actors of its host came and went.
  struct Probation {
    TimePoint until;
    std::uint32_t flaps = 0;
  };
  /// The actor is there; may be told again and again.
  Probation Join(std::uint64_t actor_id, const std::string& host, TimePoint now);
  /// The actor is gone; unknown ones are ignored, here and below.
  void Lose(std::uint64_t actor_id, TimePoint now);

  /// It did not answer an assignment for very long.
  void GaveUp(std::uint64_t actor_id, TimePoint now);
  /// It brought an episode, whatever that is worth: no silence any more.
  void Brought(std::uint64_t actor_id);

  /// Notes that its episode passed the check, or did not. @return false if these were too many bad
  /// ones in a row: refuse it.
  bool Checked(std::uint64_t actor_id, bool good);
  /// Nothing is heard of this actor from here on but `reason`, which it is told. Of too many, who
  /// was refused longest ago is forgotten: it is judged anew, as under another id.
  void Refuse(std::uint64_t actor_id, const std::string& reason) { refused_.Put(actor_id, reason); }
  /// Why it is refused, or nullptr.
  [[nodiscard]] const std::string* RefusalOf(std::uint64_t actor_id) const {
    return refused_.Find(actor_id);
  }

  /// The host is excluded for good. @return false if it is already.
  bool Exclude(const std::string& host, const std::string& reason);
  /// Why it is excluded, or nullptr.
  [[nodiscard]] const std::string* ExclusionOf(const std::string& host) const;
  [[nodiscard]] const ExcludedHosts& excluded() const { return excluded_; }

  /// The consequences for assignments to an actor.
  struct State {
    bool on_probation = false;  // of its host: asked only if nobody else is there
    bool rests = false;         // because of its silence: as well
    bool silent =
        false;  // gave up an assignment and has brought nothing since: one assignment at most
    [[nodiscard]] bool reliable() const { return !on_probation && !rests; }
  };
  [[nodiscard]] State StateOf(std::uint64_t actor_id, TimePoint now) const;
  /// When a State changes by time alone; std::nullopt: never.
  [[nodiscard]] std::optional<TimePoint> NextDeadline(TimePoint now) const;

 private:
  struct Actor {
    TimePoint trusted_from;  // by its host's flaps
    std::uint32_t silences =
        0;                  // times that it gave up assignments since it last brought something
    TimePoint rests_until;  // because of them
    std::uint32_t bad_in_a_row = 0;
  };

  TrustRules rules_;
  FlapWatch flaps_;
  std::unordered_map<std::uint64_t, Actor> actors_;  // that are there; asked for each assignment
  Newest<std::uint64_t, std::string> refused_;
  ExcludedHosts excluded_;
};

}  // namespace metronome::collect::trust
