#include "learner/collect/actor_registry.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

namespace metronome::collect {
namespace {

constexpr std::size_t kMaxReasonLength = 4096;  // idl/metronome.idl

std::string NameIn(const ActorStatus& status) {
  return status.host + ":" + std::to_string(status.pid);
}

}  // namespace

ActorRegistry::ActorRegistry(const RunDescription& description, const std::string& digest,
                             LearnerBus* bus, trust::Trust* trust)
    : incarnation_(description.incarnation),
      admission_(description, digest),
      bus_(*bus),
      trust_(*trust) {}

ActorRegistry::Verdict ActorRegistry::Hear(const ActorStatus& status, TimePoint now) {
  const std::uint64_t actor_id = status.actor_id;
  if (const std::string* refusal = trust_.RefusalOf(actor_id)) {
    SendRefusal(actor_id, *refusal);
    return Verdict::kRefused;
  }
  if (const std::string* exclusion = trust_.ExclusionOf(status.vouched_host)) {
    Refuse(actor_id, NameIn(status), *exclusion);
    return Verdict::kRefused;
  }
  const Admission::Decision decision = admission_.Judge(status);
  if (decision.verdict == Admission::Verdict::kRefuse) {
    Refuse(actor_id, NameIn(status), decision.reason);
    return Verdict::kRefused;
  }
  if (decision.verdict != Admission::Verdict::kAdmit) return Verdict::kNotYet;
  const trust::Trust::Probation probation = trust_.Join(actor_id, status.vouched_host, now);
  if (!actors_.contains(actor_id)) Welcome(status, probation, now);
  actors_[actor_id] = {NameIn(status), status.vouched_host, now, status.episodes_done,
                       status.steps_per_second};
  return Verdict::kAdmitted;
}

void ActorRegistry::Welcome(const ActorStatus& status, const trust::Trust::Probation& probation,
                            TimePoint now) const {
  spdlog::info("actor {} joins with {} env{}, from {}: {}", NameIn(status), status.envs,
               status.envs == 1 ? "" : "s", status.vouched_host, ShownBuild(status.build));
  if (probation.until <= now) return;
  spdlog::warn(
      "actors on {} came and went {} times in a row: {} gets assignments after {} s, sooner if "
      "nobody "
      "else is there",
      status.vouched_host, probation.flaps, NameIn(status),
      std::chrono::ceil<std::chrono::seconds>(probation.until - now).count());
}

void ActorRegistry::Refuse(std::uint64_t actor_id, const std::string& name,
                           const std::string& reason) {
  const std::string text = "learner refuses actor " + name + ": " + reason;
  spdlog::error("{}", text);
  trust_.Refuse(actor_id, text);
  SendRefusal(actor_id, text);
}

void ActorRegistry::SendRefusal(std::uint64_t actor_id, const std::string& reason) {
  EpisodeAssignment assignment;
  assignment.incarnation = incarnation_;
  assignment.actor_id = actor_id;
  assignment.kind = EpisodeAssignment::Kind::kRefuse;
  assignment.reason = reason.substr(0, kMaxReasonLength);
  bus_.Send(assignment);
}

bool ActorRegistry::Lose(std::uint64_t actor_id) { return actors_.erase(actor_id) > 0; }

std::string ActorRegistry::NameOf(std::uint64_t actor_id, const std::string& otherwise) const {
  const auto actor = actors_.find(actor_id);
  return actor == actors_.end() ? otherwise : actor->second.name;
}

std::set<std::string> ActorRegistry::Names() const {
  std::set<std::string> names;
  for (const auto& actor : actors_) names.insert(actor.second.name);
  return names;
}

std::map<std::uint64_t, std::string> ActorRegistry::NamesOn(const std::string& host) const {
  std::map<std::uint64_t, std::string> names;
  for (const auto& [id, actor] : actors_) {
    if (actor.host == host) names.emplace(id, actor.name);
  }
  return names;
}

std::vector<ActorReport> ActorRegistry::Report(const assignments::Roster& roster,
                                               const EpisodeCounts& counts, TimePoint now) const {
  const auto seconds_since = [now](TimePoint then) {
    return std::chrono::duration<double>(now - then).count();
  };
  std::vector<ActorReport> reports;
  for (const auto& [id, seat] : roster.actors()) {
    ActorReport report;
    const Actor& actor = actors_.at(id);
    report.name = actor.name;
    report.envs = seat.envs;
    report.episodes_done = actor.episodes_done;
    report.steps_per_second = actor.steps_per_second;
    report.silent_seconds = seconds_since(actor.heard);
    report.assignments = seat.assignments.size();
    for (const assignments::Roster::Assignment& assignment : seat.assignments) {
      report.oldest_assignment_seconds =
          std::max(report.oldest_assignment_seconds, seconds_since(assignment.since));
    }
    const trust::Trust::State trust = trust_.StateOf(id, now);
    report.on_probation = trust.on_probation;
    report.unanswering = trust.silent;
    if (const auto by = counts.by_actor.find(actor.name); by != counts.by_actor.end()) {
      report.accepted = by->second.accepted;
      report.rejected = by->second.rejected;
    }
    reports.push_back(std::move(report));
  }
  return reports;
}

}  // namespace metronome::collect
