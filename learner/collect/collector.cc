#include "learner/collect/collector.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "common/text/number_text.h"
#include "learner/collect/trust/same_bits.h"

namespace metronome::collect {
namespace {

constexpr std::size_t kMaxNumbersPerAssignment = 1024;  // idl/metronome.idl
constexpr std::size_t kSnapshotsKept = 2;
constexpr std::size_t kNamesShown = 3;

/// "(a:1, b:2)", in the actors' own words.
std::string Shown(const std::map<std::uint64_t, std::string>& names) {
  std::string text;
  std::size_t shown = 0;
  for (const auto& entry : names) {
    if (shown++ == kNamesShown) return text + ", ...)";
    text += (text.empty() ? "(" : ", ") + entry.second;
  }
  return text.empty() ? "(none of its actors is there)" : text + ")";
}

}  // namespace

Collector::Collector(LearnerBus& bus, const algorithm::Algorithm& algorithm,
                     const RunDescription& description, const CollectRules& rules,
                     const std::string& digest, trust::ExcludedHosts excluded)
    : bus_(bus),
      algorithm_(algorithm),
      incarnation_(description.incarnation),
      rules_(rules.assignments),
      trust_(rules.trust, std::move(excluded)),
      registry_(description, digest, &bus, &trust_),
      book_(rules.assignments),
      plan_(rules.assignments, &book_, &trust_),
      batches_(rules_.episodes_per_update, rules_.first_version),
      desk_(rules.audit, &book_, &plan_, &batches_) {}

void Collector::OnStatus(const ActorStatus& status, TimePoint now) {
  const bool is_new = !roster().actors().contains(status.actor_id);
  switch (registry_.Hear(status, now)) {
    case ActorRegistry::Verdict::kNotYet:
      return;
    case ActorRegistry::Verdict::kRefused:
      plan_.Lose(status.actor_id, now);
      return;
    case ActorRegistry::Verdict::kAdmitted:
      plan_.Join(status.actor_id, status.vouched_host, status.envs, now);
      if (is_new && counts_.HasManyActors()) counts_.KeepActors(registry_.Names());
      return;
  }
}

// Once a process, when the actors of the beginning are all there.
void Collector::WarnOfManyEnvs() {
  const std::uint64_t envs = roster().envs(), episodes = rules_.episodes_per_update;
  if (2 * envs <= episodes || has_warned_of_envs_) return;
  has_warned_of_envs_ = true;
  spdlog::warn(
      "{} envs for {} episodes an update: envs beyond half of that are often idle; a new run can "
      "keep "
      "them busy: deploy/train TASK --config deploy/wide.textproto --set "
      "collection.episodes_per_update={}",
      envs, episodes, 2 * envs);
}

void Collector::OnLost(std::uint64_t actor_id, TimePoint now) {
  const std::string name = Called(actor_id);
  trust_.Lose(actor_id, now);
  const std::size_t assignments = plan_.Lose(actor_id, now);
  if (!registry_.Lose(actor_id)) return;
  spdlog::info(
      "actor {} is gone{}", name,
      assignments > 0 ? "; going to others: " + text::Counted(assignments, "assignment") : "");
}

// The way of an episode from the wire to its batch: for this learner? from one that may speak?
// asked for? right? does it stand, or is another to play it too? Then it is booked and kept.
void Collector::OnEpisode(EpisodeMessage message, TimePoint now) {
  using Standing = assignments::NumberBook::Claim::Standing;
  const std::uint64_t actor_id = message.actor_id;
  const std::uint64_t number = message.episode.number;
  if (message.incarnation != incarnation_) {
    ++counts_.stale;
    return;
  }
  const assignments::NumberBook::Claim claim = book_.ClaimOf(number, actor_id);
  // Its host too: an actor that was lost before that was excluded is not refused itself, and may
  // not be dead.
  if (trust_.RefusalOf(actor_id) != nullptr || trust_.ExclusionOf(claim.host) != nullptr) {
    return Drop(actor_id, "its actor is refused", now);
  }
  if (claim.standing == Standing::kNotAssigned) {
    return Drop(actor_id, "episode " + std::to_string(number) + " was not assigned to it", now);
  }
  if (claim.standing == Standing::kDuplicate) return Compare(message.episode, actor_id, now);
  book_.Arrive(number);
  plan_.Free(number, actor_id, now);
  // First: the freed env does not wait for the check. But nothing is settled meanwhile, for what
  // is being checked may be the second answer that a lonely number waits for.
  SendPlan(now);
  const PolicySnapshot& snapshot = snapshots_.at(claim.weights_version);
  if (const auto fault = algorithm_.Check(message.episode, snapshot)) {
    return Reject(number, actor_id, *fault, now);
  }
  trust_.Checked(actor_id, true);
  Follow(desk_.Hear({actor_id, claim.host, std::move(message.episode)}), number, actor_id, now);
}

// A sample that answers no assignment: counted, nothing else changes.
void Collector::Drop(std::uint64_t actor_id, const std::string& reason, TimePoint now) {
  counts_.CountRejected(registry_.NameOf(actor_id, "strangers"), reason);
  Complain("a sample of " + Called(actor_id) + " is dropped: " + reason, now);
}

void Collector::OnBadSample(const BadSample& sample, TimePoint now) {
  counts_.CountRejected("strangers", sample.topic + ": " + sample.reason);
  Complain("a sample of " + sample.topic + " is dropped: " + sample.reason, now);
}

// A number that has been brought before.
void Collector::Compare(const Episode& episode, std::uint64_t actor_id, TimePoint now) {
  const Episode* kept = batches_.Find(episode.number);
  const bool differs = kept != nullptr && !trust::SameBits(*kept, episode);
  counts_.CountDuplicate(registry_.NameOf(actor_id, "lost actors"), differs);
  plan_.Free(episode.number, actor_id, now);
  if (!differs) return;
  const bool again = desk_.Doubt(episode.number);
  Complain("episode " + std::to_string(episode.number) + " came twice, the second time from " +
               Called(actor_id) +
               ", and the two differ: one of the two machines computes wrongly; " +
               (again ? "two hosts play it again" : "the second one is dropped"),
           now);
}

void Collector::Reject(std::uint64_t number, std::uint64_t actor_id, const std::string& reason,
                       TimePoint now) {
  book_.PutBack(number);
  counts_.CountRejected(registry_.NameOf(actor_id, "strangers"), reason);
  Complain("episode " + std::to_string(number) + " of " + Called(actor_id) +
               " is dropped and reassigned: " + reason,
           now);
  if (trust_.Checked(actor_id, false)) return;
  Refuse(actor_id, Called(actor_id),
         "it keeps sending episodes that cannot be right, the last because " + reason, now);
}

void Collector::Follow(AuditDesk::Ruling ruling, std::uint64_t number, std::uint64_t actor_id,
                       TimePoint now) {
  if (ruling.settled) Enter(*std::move(ruling.settled));
  for (const std::string& host : ruling.guilty) Exclude(host, number, now);
  if (!ruling.disputed) return;
  spdlog::error(
      "AUDIT: the host of {} and another one differ on episode {}; a further host decides{}",
      Called(actor_id), number,
      plan_.HasOther(number, now) ? "" : ", and the run waits for it: start an actor there");
}

void Collector::Enter(Settled settled) {
  book_.Accept(settled.episode.number, std::move(settled.vouchers));
  counts_.CountAccepted(registry_.NameOf(settled.actor_id, "lost actors"));
  batches_.Put(std::move(settled.episode));
}

void Collector::Refuse(std::uint64_t actor_id, const std::string& name, const std::string& reason,
                       TimePoint now) {
  plan_.Lose(actor_id, now);
  registry_.Refuse(actor_id, name, reason);
}

// Nothing that only this host vouches for enters an update from here on.
void Collector::Exclude(const std::string& host, std::uint64_t number, TimePoint now) {
  const auto names = registry_.NamesOn(host);
  const std::string reason = "host " + host + " " + Shown(names) +
                             " computes wrongly: on episode " + std::to_string(number) +
                             " it differs from what other hosts agree on, or from itself";
  if (!trust_.Exclude(host, reason)) return;
  spdlog::error("AUDIT: {}; it is excluded from this run", reason);
  for (const auto& [actor_id, name] : names) Refuse(actor_id, name, reason, now);
  desk_.Disregard(host);
}

std::optional<Collector::TimePoint> Collector::SendAssignments(TimePoint now) {
  for (Settled& settled : desk_.SettleLonely(now)) Enter(std::move(settled));
  SendPlan(now);
  std::optional<TimePoint> due = plan_.NextDeadline(now);
  if (desk_.due()) due = std::min(due.value_or(*desk_.due()), *desk_.due());
  return due;
}

void Collector::SendPlan(TimePoint now) {
  for (const assignments::Handout& handout : plan_.HandOut(now)) {
    EpisodeAssignment assignment;
    assignment.incarnation = incarnation_;
    assignment.actor_id = handout.actor_id;
    assignment.weights_version = handout.weights_version;
    const auto& numbers = handout.numbers;
    for (std::size_t first = 0; first < numbers.size(); first += kMaxNumbersPerAssignment) {
      const std::size_t last = std::min(numbers.size(), first + kMaxNumbersPerAssignment);
      assignment.numbers.assign(numbers.begin() + std::ptrdiff_t(first),
                                numbers.begin() + std::ptrdiff_t(last));
      // Not connected: its next status brings it back, meanwhile others may play these.
      if (!bus_.Send(assignment)) plan_.Lose(handout.actor_id, now);
    }
  }
  counts_.reassigned = plan_.reassigned();
}

Collector::Collected Collector::Take(std::uint64_t batch, TimePoint now) {
  WarnOfManyEnvs();
  return {batches_.Take(batch), plan_.TakeIdleShare(now)};
}

void Collector::Publish(std::uint64_t version, const std::vector<Episode>& batch, TimePoint now) {
  batches_.CountEntered(batch);
  // Without overlap nothing could be assigned meanwhile: that is no idleness of collecting.
  if (rules_.overlap == 0) plan_.TakeIdleShare(now);
  book_.Publish(version);
  desk_.Learnt(version * rules_.episodes_per_update);
}

void Collector::AddSnapshot(PolicySnapshot snapshot) {
  const std::uint64_t version = snapshot.version;
  snapshots_.insert_or_assign(version, std::move(snapshot));
  while (snapshots_.size() > kSnapshotsKept) snapshots_.erase(snapshots_.begin());
}

void Collector::Complain(const std::string& text, TimePoint now) {
  if (!complaints_.Pass(now)) return;
  const std::uint64_t withheld = complaints_.TakeWithheld();
  spdlog::error("{}{}", text, withheld > 0 ? " (and " + std::to_string(withheld) + " more)" : "");
}

std::string Collector::Called(std::uint64_t actor_id) const {
  return registry_.NameOf(actor_id, "unknown actor " + std::to_string(actor_id));
}

}  // namespace metronome::collect
