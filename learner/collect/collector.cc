#include "learner/collect/collector.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

namespace metronome {
namespace {

constexpr std::size_t kMaxNumbersPerOrder = 1024;  // idl/metronome.idl
constexpr std::size_t kMaxReasonLength = 4096;     // idl/metronome.idl
constexpr std::size_t kMaxRefusals = 4096;         // remembered; whoever floods us is forgotten
constexpr std::size_t kSnapshotsKept = 2;
constexpr std::chrono::seconds kAuditPatience{5};  // with who is to play an episode again

}  // namespace

Collector::Collector(LearnerBus& bus, const Learning& learning, const RunDescription& description,
                     const OrderRules& rules, const std::string& digest, ExcludedHosts excluded)
    : bus_(bus),
      learning_(learning),
      incarnation_(description.incarnation),
      episodes_per_update_(rules.episodes_per_update),
      admission_(description, digest),
      ledger_(rules),
      audit_(rules.audit),
      batches_(rules.episodes_per_update, rules.updates_total, rules.first_version),
      excluded_(std::move(excluded)) {}

void Collector::OnStatus(const ActorStatus& status, TimePoint now) {
  if (const auto refusal = refusals_.find(status.actor_id); refusal != refusals_.end()) {
    SendRefusal(status.actor_id, refusal->second);
    return;
  }
  const std::string name = status.host + ":" + std::to_string(status.pid);
  if (const auto excluded = excluded_.find(status.host); excluded != excluded_.end()) {
    RefuseActor(status.actor_id, name, excluded->second, now);
    return;
  }
  const Admission::Decision decision = admission_.Judge(status);
  if (decision.verdict == Admission::Verdict::kRefuse) {
    RefuseActor(status.actor_id, name, decision.reason, now);
  }
  if (decision.verdict != Admission::Verdict::kAdmit) return;
  const TimePoint trusted_from = flaps_.Join(status.actor_id, status.host, now);
  if (names_.insert_or_assign(status.actor_id, name).second) {
    Welcome(status, name, trusted_from, now);
  }
  last_words_[status.actor_id] = {now, status.episodes_done, status.steps_per_second};
  ledger_.Join(status.actor_id, name, status.slots, now, trusted_from);
  WarnOfManySlots();
}

void Collector::Welcome(const ActorStatus& status, const std::string& name, TimePoint trusted_from,
                        TimePoint now) const {
  spdlog::info("actor {} joins with {} slot{}", name, status.slots, status.slots == 1 ? "" : "s");
  if (trusted_from <= now) return;
  spdlog::warn(
      "actors on {} came and went {} times in a row: {} gets orders after {} s, sooner if nobody "
      "else is there",
      status.host, flaps_.FlapsOf(status.host), name,
      std::chrono::ceil<std::chrono::seconds>(trusted_from - now).count());
}

void Collector::WarnOfManySlots() {
  const std::uint64_t slots = ledger_.slots();
  if (2 * slots <= episodes_per_update_ || slots <= slots_warned_of_) return;
  slots_warned_of_ = slots;
  spdlog::warn(
      "{} slots for {} episodes an update: slots beyond half of that will often be idle; the wide "
      "preset (deploy/wide.textproto) suits many machines",
      slots, episodes_per_update_);
}

void Collector::RefuseActor(std::uint64_t actor_id, const std::string& name,
                            const std::string& reason, TimePoint now) {
  const std::string text = "learner refuses actor " + name + ": " + reason;
  spdlog::error("{}", text);
  ledger_.Refuse(actor_id, now);
  if (refusals_.size() >= kMaxRefusals) refusals_.clear();
  refusals_[actor_id] = text;
  SendRefusal(actor_id, text);
}

void Collector::SendRefusal(std::uint64_t actor_id, const std::string& reason) {
  EpisodeOrder order;
  order.incarnation = incarnation_;
  order.actor_id = actor_id;
  order.kind = EpisodeOrder::Kind::kRefuse;
  order.reason = reason.substr(0, kMaxReasonLength);
  bus_.Send(order);
}

void Collector::OnLost(std::uint64_t actor_id, TimePoint now) {
  flaps_.Lose(actor_id, now);
  const std::size_t orders = ledger_.Lose(actor_id, now);
  if (names_.contains(actor_id)) {
    spdlog::info("actor {} is gone{}", NameOf(actor_id),
                 orders > 0 ? "; its " + std::to_string(orders) + " orders go to others" : "");
  }
  names_.erase(actor_id);
  last_words_.erase(actor_id);
}

void Collector::OnEpisode(EpisodeMessage message, TimePoint now) {
  if (message.incarnation != incarnation_) {
    ++stale_;
    return;
  }
  if (IsBarred(message.actor_id)) {
    Discard(message.actor_id, "its actor is refused", now);
    return;
  }
  const std::uint64_t number = message.episode.number;
  switch (ledger_.StandingOf(number, message.actor_id)) {
    case OrderLedger::Standing::kWanted:
      ledger_.Arrive(number, message.actor_id, now);
      // First: the freed slot does not wait for the check. But nothing is settled meanwhile, for
      // what is being checked may be the second answer that a lonely number waits for.
      SendPlan(now);
      Judge(std::move(message.episode), message.actor_id, now);
      return;
    case OrderLedger::Standing::kDuplicate:
      OnDuplicate(message.episode, message.actor_id, now);
      return;
    case OrderLedger::Standing::kNotOrdered:
      Discard(message.actor_id, "episode " + std::to_string(number) + " was not ordered from it",
              now);
      return;
  }
}

// An actor that was lost before its host was excluded was not refused itself, and may not be dead.
bool Collector::IsBarred(std::uint64_t actor_id) const {
  return ledger_.IsRefused(actor_id) || excluded_.contains(ledger_.HostOf(actor_id));
}

void Collector::Judge(Episode episode, std::uint64_t actor_id, TimePoint now) {
  const std::uint64_t number = episode.number;
  const PolicySnapshot& snapshot = snapshots_.at(ledger_.BehaviourVersion(number));
  const std::optional<std::string> reason = learning_.Check(episode, snapshot);
  if (!reason && audit_.IsChosen(number)) {
    Hear(std::move(episode), actor_id, now);
    return;
  }
  if (!reason) {
    ledger_.Accept(number, actor_id);
    batches_.Put(std::move(episode));
    return;
  }
  Complain("episode " + std::to_string(number) + " of " + NameOf(actor_id) +
               " is dropped and ordered again: " + *reason,
           now);
  if (!ledger_.Reject(number, actor_id, *reason)) return;
  RefuseActor(actor_id, NameOf(actor_id),
              "it keeps sending episodes that cannot be right, the last because " + *reason, now);
}

// Of an episode that is audited: what stands is what two agree on.
void Collector::Hear(Episode episode, std::uint64_t actor_id, TimePoint now) {
  const std::uint64_t number = episode.number;
  Audit::Verdict verdict = audit_.Hear({actor_id, ledger_.HostOf(actor_id), std::move(episode)});
  ledger_.AskAnother(number, actor_id, verdict.disputed);
  if (verdict.settled) {
    ledger_.AcceptHeard(number, verdict.settled->actor_id, std::move(verdict.vouchers));
    batches_.Put(std::move(verdict.settled->episode));
  } else if (!audit_.IsPending(number)) {
    ledger_.Reopen(number);
  }
  for (const std::string& host : verdict.guilty) ExcludeHost(host, number, now);
  if (!verdict.disputed) return;
  spdlog::error(
      "AUDIT: the host of {} and another one differ on episode {}; a further host decides{}",
      NameOf(actor_id), number,
      ledger_.HasOther(number) ? "" : ", and the run waits for it: start an actor there");
}

// Where nobody else can play an audited episode the run goes on without: it is counted. But first
// it waits a little: others may be on their way, at the start or after a fall.
// @return when to try again.
std::optional<Collector::TimePoint> Collector::SettleLonely(TimePoint now) {
  std::vector<std::uint64_t> lonely;
  for (const std::uint64_t number : audit_.Pending()) {
    if (audit_.IsDisputed(number)) continue;
    if (!ledger_.HasOther(number)) {
      lonely.push_back(number);
    } else {
      lonely_since_.reset();
    }
  }
  if (lonely.empty()) return std::nullopt;
  if (!lonely_since_) lonely_since_ = now;
  if (now < *lonely_since_ + kAuditPatience) return *lonely_since_ + kAuditPatience;
  for (const std::uint64_t number : lonely) {
    Audit::Opinion only = audit_.SettleAlone(number);
    ledger_.AcceptHeard(number, only.actor_id, {only.host});
    batches_.Put(std::move(only.episode));
  }
  return std::nullopt;
}

// Nothing that only this host vouches for enters an update from here on.
void Collector::ExcludeHost(const std::string& host, std::uint64_t number, TimePoint now) {
  const std::string reason = "host " + host + " computes wrongly: on episode " +
                             std::to_string(number) +
                             " it differs from what other hosts agree on, or from itself";
  if (!excluded_.emplace(host, reason).second) return;
  spdlog::error("AUDIT: {}; it is excluded from this run", reason);
  for (const auto& [actor_id, name] : names_) {
    if (ledger_.HostOf(actor_id) == host) RefuseActor(actor_id, name, reason, now);
  }
  for (const std::uint64_t unheard : audit_.Forget(host)) ledger_.Reopen(unheard);
  for (const std::uint64_t doubtful : ledger_.OnTheWordOf(host)) {
    if (batches_.Withdraw(doubtful)) ledger_.Reopen(doubtful);
  }
}

void Collector::OnDuplicate(const Episode& episode, std::uint64_t actor_id, TimePoint now) {
  const Episode* kept = batches_.Find(episode.number);
  const bool differs = kept != nullptr && !SameBits(*kept, episode);
  ledger_.ArriveAgain(episode.number, actor_id, differs, now);
  if (!differs) return;
  // Once: whoever sends a third answer, and a fourth, cannot hold the run up.
  const bool doubted = audit_.on() && !audit_.IsChosen(episode.number);
  const bool again = doubted && batches_.Withdraw(episode.number);
  if (again) {
    audit_.Choose(episode.number);
    ledger_.Reopen(episode.number);
  }
  Complain("episode " + std::to_string(episode.number) + " came twice, the second time from " +
               NameOf(actor_id) +
               ", and the two differ: one of the two machines computes wrongly; " +
               (again ? "two hosts play it again" : "the second one is dropped"),
           now);
}

void Collector::OnBadSample(const BadSample& sample, TimePoint now) {
  ledger_.Discard(0, sample.topic + ": " + sample.reason);
  Complain("a sample of " + sample.topic + " is dropped: " + sample.reason, now);
}

void Collector::Discard(std::uint64_t actor_id, const std::string& reason, TimePoint now) {
  ledger_.Discard(actor_id, reason);
  Complain("a sample of " + NameOf(actor_id) + " is dropped: " + reason, now);
}

void Collector::Complain(const std::string& text, TimePoint now) {
  if (!complaints_.Pass(now)) return;
  const std::uint64_t withheld = complaints_.TakeWithheld();
  spdlog::error("{}{}", text,
                withheld > 0 ? " (and " + std::to_string(withheld) + " more complaints)" : "");
}

std::string Collector::NameOf(std::uint64_t actor_id) const {
  const auto name = names_.find(actor_id);
  return name != names_.end() ? name->second : "unknown actor " + std::to_string(actor_id);
}

std::vector<ActorReport> Collector::ReportActors(TimePoint now) const {
  const auto seconds_since = [now](TimePoint then) {
    return std::chrono::duration<double>(now - then).count();
  };
  std::vector<ActorReport> reports;
  for (const OrderLedger::ActorOrders& actor : ledger_.OrdersByActor(now)) {
    ActorReport report;
    report.name = actor.name;
    report.slots = actor.slots;
    report.orders = actor.orders;
    if (actor.oldest) report.oldest_order_seconds = seconds_since(*actor.oldest);
    report.on_probation = !actor.trusted;
    report.unanswering = actor.silent;
    if (const auto said = last_words_.find(actor.actor_id); said != last_words_.end()) {
      report.episodes_done = said->second.episodes_done;
      report.steps_per_second = said->second.steps_per_second;
      report.silent_seconds = seconds_since(said->second.heard);
    }
    const auto& by_actor = ledger_.counts().by_actor;
    if (const auto counts = by_actor.find(actor.name); counts != by_actor.end()) {
      report.accepted = counts->second.accepted;
      report.rejected = counts->second.rejected;
    }
    reports.push_back(std::move(report));
  }
  return reports;
}

void Collector::AddSnapshot(PolicySnapshot snapshot) {
  const std::uint64_t version = snapshot.version;
  snapshots_.insert_or_assign(version, std::move(snapshot));
  while (snapshots_.size() > kSnapshotsKept) snapshots_.erase(snapshots_.begin());
}

void Collector::CountEntered(const std::vector<Episode>& batch) { batches_.CountEntered(batch); }

std::string Collector::AuditText() const {
  if (!audit_.on()) return "";
  const Audit::Counts& counts = audit_.counts();
  std::string text = "audit: " + std::to_string(counts.agreed) +
                     " episodes were played by two actors and agree in every bit, " +
                     std::to_string(counts.alone) + " more had nobody to play them again, " +
                     std::to_string(counts.disputes) + " were disputed; excluded hosts: ";
  if (excluded_.empty()) return text + "none";
  std::string separator;
  for (const auto& host : excluded_) text += std::exchange(separator, ", ") + host.first;
  return text;
}

std::optional<Collector::TimePoint> Collector::SendOrders(TimePoint now) {
  const std::optional<TimePoint> audit_due = SettleLonely(now);
  SendPlan(now);
  const std::optional<TimePoint> ledger_due = ledger_.NextDeadline(now);
  if (!audit_due || !ledger_due) return audit_due ? audit_due : ledger_due;
  return std::min(*audit_due, *ledger_due);
}

void Collector::SendPlan(TimePoint now) {
  for (const Assignment& assignment : ledger_.Plan(now)) {
    EpisodeOrder order;
    order.incarnation = incarnation_;
    order.actor_id = assignment.actor_id;
    order.weights_version = assignment.weights_version;
    const auto& numbers = assignment.numbers;
    for (std::size_t first = 0; first < numbers.size(); first += kMaxNumbersPerOrder) {
      const std::size_t last = std::min(numbers.size(), first + kMaxNumbersPerOrder);
      order.numbers.assign(numbers.begin() + std::ptrdiff_t(first),
                           numbers.begin() + std::ptrdiff_t(last));
      // Not connected: its next status brings it back, meanwhile others may play these.
      if (!bus_.Send(order)) ledger_.Lose(assignment.actor_id, now);
    }
  }
}

}  // namespace metronome
