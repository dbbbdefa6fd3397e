#include "learner/collect/trust/trust.h"

#include <utility>

#include "learner/collect/trust/doubling.h"

namespace metronome::collect::trust {

Trust::Trust(const TrustRules& rules, ExcludedHosts excluded)
    : rules_(rules), flaps_(rules.flaps), refused_(rules.refused), excluded_(std::move(excluded)) {}

Trust::Probation Trust::Join(std::uint64_t actor_id, const std::string& host, TimePoint now) {
  const TimePoint until = flaps_.Join(actor_id, host, now);
  actors_[actor_id].trusted_from = until;
  return {until, flaps_.FlapsOf(host)};
}

void Trust::Lose(std::uint64_t actor_id, TimePoint now) {
  flaps_.Lose(actor_id, now);
  actors_.erase(actor_id);
}

void Trust::GaveUp(std::uint64_t actor_id, TimePoint now) {
  const auto actor = actors_.find(actor_id);
  if (actor == actors_.end()) return;
  const std::uint32_t times = ++actor->second.silences;
  actor->second.rests_until = now + Doubling(times, rules_.first_rest, rules_.longest_rest);
}

void Trust::Brought(std::uint64_t actor_id) {
  const auto actor = actors_.find(actor_id);
  if (actor == actors_.end()) return;
  actor->second.silences = 0;
  actor->second.rests_until = {};
}

bool Trust::Checked(std::uint64_t actor_id, bool good) {
  const auto actor = actors_.find(actor_id);
  if (actor == actors_.end()) return true;
  std::uint32_t& bad = actor->second.bad_in_a_row;
  bad = good ? 0 : bad + 1;
  return bad <= rules_.bad_answers_allowed;
}

bool Trust::Exclude(const std::string& host, const std::string& reason) {
  return excluded_.emplace(host, reason).second;
}

const std::string* Trust::ExclusionOf(const std::string& host) const {
  const auto found = excluded_.find(host);
  return found == excluded_.end() ? nullptr : &found->second;
}

Trust::State Trust::StateOf(std::uint64_t actor_id, TimePoint now) const {
  const auto found = actors_.find(actor_id);
  if (found == actors_.end()) return {};
  const Actor& actor = found->second;
  return {actor.trusted_from > now, actor.rests_until > now, actor.silences > 0};
}

std::optional<Trust::TimePoint> Trust::NextDeadline(TimePoint now) const {
  std::optional<TimePoint> next;
  for (const auto& [id, actor] : actors_) {
    for (const TimePoint due : {actor.trusted_from, actor.rests_until}) {
      if (due > now && (!next || due < *next)) next = due;
    }
  }
  return next;
}

}  // namespace metronome::collect::trust
