#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/messages/episode.h"

namespace metronome::collect::trust {

/// How much is audited.
struct AuditRules {
  double share = 0;       // of all episodes, in [0, 1], that are played by two actors
  std::uint64_t key = 0;  // decides which; no actor may know it
};

/// Compares what several actors brought for one episode number. An episode is a pure function of
/// configuration, weights and number, so two that differ in one bit prove that a machine computes
/// wrongly, or lies; hosts, not actors, are judged, as the middleware knows them (never by a name
/// that an actor gives itself). Pure logic; not thread-safe.
class Audit {
 public:
  /// One actor's answer.
  struct Opinion {
    std::uint64_t actor_id = 0;
    std::string host;
    Episode episode;
  };
  struct Verdict {
    std::optional<Opinion> settled;     // what stands: the earliest that others agree with
    std::vector<std::string> vouchers;  // hosts that brought these bits
    std::vector<std::string> guilty;    // hosts that brought other bits, or two answers
    bool disputed = false;              // not settled: hosts differ, a further one must decide
  };
  struct Counts {
    std::uint64_t agreed = 0;    // episodes that two or more actors brought alike
    std::uint64_t alone = 0;     // chosen, but there was nobody to play them again
    std::uint64_t disputes = 0;  // episodes on which hosts differed
  };

  explicit Audit(const AuditRules& rules) : rules_(rules) {}

  [[nodiscard]] bool on() const { return rules_.share > 0; }
  /// The episode is to be played twice.
  [[nodiscard]] bool IsChosen(std::uint64_t number) const;
  /// It is, whatever the key says: there is reason to doubt it.
  void Choose(std::uint64_t number) { doubted_.insert(number); }
  /// Numbers below this one are learnt from: what was doubted of them is forgotten.
  void Learnt(std::uint64_t first_left) {
    doubted_.erase(doubted_.begin(), doubted_.lower_bound(first_left));
  }

  /// Settled when two actors agree and nobody differs, or when two hosts agree. A settled number,
  /// and the answers of guilty hosts, are forgotten.
  Verdict Hear(Opinion opinion);
  /// Nobody else is there: the only opinion stands. @throws std::logic_error if there is none, or
  /// if it is disputed.
  Opinion SettleAlone(std::uint64_t number);
  /// Numbers with an opinion and without a verdict.
  [[nodiscard]] std::vector<std::uint64_t> Pending() const;
  [[nodiscard]] bool IsPending(std::uint64_t number) const { return pending_.contains(number); }
  [[nodiscard]] bool IsDisputed(std::uint64_t number) const;
  /// Strikes this host's answers for pending numbers. @return numbers that nobody else has
  /// an opinion on.
  std::vector<std::uint64_t> Forget(const std::string& host);

  [[nodiscard]] const Counts& counts() const { return counts_; }

 private:
  using Opinions = std::vector<Opinion>;

  AuditRules rules_;
  std::set<std::uint64_t> doubted_;
  std::map<std::uint64_t, Opinions> pending_;  // by number; never empty
  Counts counts_;
};

}  // namespace metronome::collect::trust
