#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/messages/episode.h"
#include "learner/collect/assignments/assignment_plan.h"
#include "learner/collect/assignments/number_book.h"
#include "learner/collect/batch_store.h"
#include "learner/collect/trust/audit.h"
#include "learner/collect/trust/excluded_hosts.h"

namespace metronome::collect {

/// An episode that stands.
struct Settled {
  std::uint64_t actor_id = 0;
  Episode episode;
  std::vector<std::string> vouchers;  // hosts that brought these bits
};

/// Hears what was right by itself, has somebody else play what is to be audited, and says what
/// stands. Keeps the book of numbers true to what it decides, but for accepting. Pure logic on
/// given time points; not thread-safe.
class AuditDesk {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  struct Ruling {
    std::optional<Settled> settled;   // it is to be accepted; else somebody is asked again
    std::vector<std::string> guilty;  // hosts to be excluded, once that is done
    bool disputed = false;            // hosts differ: a further one decides
  };

  /// All but the rules must outlive the desk.
  AuditDesk(const trust::AuditRules& rules, assignments::NumberBook* book,
            const assignments::AssignmentPlan* plan, BatchStore* batches);

  /// Of an episode that has arrived and passed its check.
  Ruling Hear(trust::Audit::Opinion opinion);
  /// Where nobody else can play an audited episode the run goes on without: it is counted. But
  /// first it waits a little: others may be on their way, at the start or after a fall.
  std::vector<Settled> SettleLonely(TimePoint now);
  /// When SettleLonely has work to do even if nothing happens.
  [[nodiscard]] std::optional<TimePoint> due() const { return due_; }

  /// An accepted episode came again with other bits. @return whether two hosts play it anew.
  bool Doubt(std::uint64_t number);
  /// The host is excluded: what only it vouches for and is not learnt from yet is played anew.
  void Disregard(const std::string& host);
  /// Numbers below this one are learnt from.
  void Learnt(std::uint64_t first_left) { audit_.Learnt(first_left); }

  /// The audit's findings, for people; empty if nothing is audited.
  [[nodiscard]] std::string Text(const trust::ExcludedHosts& excluded) const;

 private:
  trust::Audit audit_;
  assignments::NumberBook& book_;
  const assignments::AssignmentPlan& plan_;
  BatchStore& batches_;
  std::optional<TimePoint> lonely_since_;  // nobody is there to play audited episodes again
  std::optional<TimePoint> due_;
};

}  // namespace metronome::collect
