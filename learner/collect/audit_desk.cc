#include "learner/collect/audit_desk.h"

#include <utility>

#include "common/text/number_text.h"

namespace metronome::collect {
namespace {

constexpr std::chrono::seconds kPatience{5};  // with who is to play an episode again

}  // namespace

AuditDesk::AuditDesk(const trust::AuditRules& rules, assignments::NumberBook* book,
                     const assignments::AssignmentPlan* plan, BatchStore* batches)
    : audit_(rules), book_(*book), plan_(*plan), batches_(*batches) {}

AuditDesk::Ruling AuditDesk::Hear(trust::Audit::Opinion opinion) {
  const std::uint64_t number = opinion.episode.number;
  const assignments::NumberBook::Player player{opinion.actor_id, opinion.host};
  if (!audit_.IsChosen(number)) {
    return {Settled{player.actor_id, std::move(opinion.episode), {player.host}}, {}, false};
  }
  trust::Audit::Verdict verdict = audit_.Hear(std::move(opinion));
  Ruling ruling{std::nullopt, std::move(verdict.guilty), verdict.disputed};
  if (verdict.settled) {
    ruling.settled = Settled{verdict.settled->actor_id, std::move(verdict.settled->episode),
                             std::move(verdict.vouchers)};
  } else if (audit_.IsPending(number)) {
    book_.AskAnother(number, player, verdict.disputed);
  } else {
    book_.Reopen(number);
  }
  return ruling;
}

std::vector<Settled> AuditDesk::SettleLonely(TimePoint now) {
  due_.reset();
  std::vector<std::uint64_t> lonely;
  for (const std::uint64_t number : audit_.Pending()) {
    if (audit_.IsDisputed(number)) continue;
    if (plan_.HasOther(number, now)) {
      lonely_since_.reset();
    } else {
      lonely.push_back(number);
    }
  }
  if (lonely.empty()) return {};
  if (!lonely_since_) lonely_since_ = now;
  if (now < *lonely_since_ + kPatience) {
    due_ = *lonely_since_ + kPatience;
    return {};
  }
  std::vector<Settled> settled;
  for (const std::uint64_t number : lonely) {
    trust::Audit::Opinion only = audit_.SettleAlone(number);
    settled.push_back({only.actor_id, std::move(only.episode), {only.host}});
  }
  return settled;
}

// Once: whoever sends a third answer, and a fourth, cannot hold the run up.
bool AuditDesk::Doubt(std::uint64_t number) {
  if (!audit_.on() || audit_.IsChosen(number) || !batches_.Withdraw(number)) return false;
  audit_.Choose(number);
  book_.Reopen(number);
  return true;
}

void AuditDesk::Disregard(const std::string& host) {
  for (const std::uint64_t unheard : audit_.Forget(host)) book_.Reopen(unheard);
  for (const std::uint64_t doubtful : book_.OnTheWordOf(host)) {
    if (batches_.Withdraw(doubtful)) book_.Reopen(doubtful);
  }
}

std::string AuditDesk::Text(const trust::ExcludedHosts& excluded) const {
  if (!audit_.on()) return "";
  const trust::Audit::Counts& counts = audit_.counts();
  std::string text = "audit: " + text::Counted(counts.agreed, "episode") +
                     " played by two actors, equal in every bit; " + std::to_string(counts.alone) +
                     " with nobody to play them again; " + std::to_string(counts.disputes) +
                     " disputed; excluded hosts: ";
  if (excluded.empty()) return text + "none";
  std::string separator;
  for (const auto& host : excluded) text += std::exchange(separator, ", ") + host.first;
  return text;
}

}  // namespace metronome::collect
