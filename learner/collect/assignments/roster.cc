#include "learner/collect/assignments/roster.h"

#include <algorithm>
#include <functional>
#include <iterator>

namespace metronome::collect::assignments {
namespace {

constexpr std::ptrdiff_t kGivenUpKept = 64;  // of an actor

using Assignments = std::vector<Roster::Assignment>;

Assignments::iterator Find(Assignments* assignments, std::uint64_t number) {
  return std::find_if(
      assignments->begin(), assignments->end(),
      [&](const Roster::Assignment& assignment) { return assignment.number == number; });
}

}  // namespace

void Roster::Join(std::uint64_t actor_id, const std::string& host, std::uint32_t envs) {
  const auto [at, is_new] = actors_.try_emplace(actor_id);
  Actor& actor = at->second;
  if (!is_new) envs_ -= actor.envs;
  actor.host = host;
  actor.envs = std::max<std::uint32_t>(envs, 1);
  envs_ += actor.envs;
}

std::vector<std::uint64_t> Roster::Leave(std::uint64_t actor_id) {
  std::vector<std::uint64_t> numbers;
  const auto actor = actors_.find(actor_id);
  if (actor == actors_.end()) return numbers;
  for (const Assignment& assignment : actor->second.assignments)
    numbers.push_back(assignment.number);
  envs_ -= actor->second.envs;
  actors_.erase(actor);
  return numbers;
}

void Roster::Give(std::uint64_t actor_id, std::uint64_t number, TimePoint now) {
  actors_.at(actor_id).assignments.push_back({number, now});
}

std::optional<std::chrono::nanoseconds> Roster::Release(std::uint64_t actor_id,
                                                        std::uint64_t number, TimePoint now) {
  const auto actor = actors_.find(actor_id);
  if (actor == actors_.end()) return std::nullopt;
  Assignments& assignments = actor->second.assignments;
  const auto assignment = Find(&assignments, number);
  if (assignment == assignments.end()) {
    // Given up too early: the estimate of how long an episode takes must learn from it.
    Assignments& given_up = actor->second.given_up;
    const auto late = Find(&given_up, number);
    if (late == given_up.end()) return std::nullopt;
    const auto took = now - late->since;
    given_up.erase(late);
    return took;
  }
  const auto took = now - assignment->since;
  const auto index = static_cast<std::size_t>(assignment - assignments.begin());
  assignments.erase(assignment);
  const std::size_t last_env = actor->second.envs - 1;
  if (index <= last_env && assignments.size() > last_env) assignments[last_env].since = now;
  return took;
}

std::map<std::uint64_t, std::vector<std::uint64_t>> Roster::GiveUp(
    const std::function<bool(const Assignment&)>& is_lost) {
  std::map<std::uint64_t, std::vector<std::uint64_t>> numbers;
  const auto is_it = std::cref(is_lost);  // algorithms copy
  for (auto& [id, actor] : actors_) {
    if (std::none_of(actor.assignments.begin(), actor.assignments.end(), is_it)) continue;
    Assignments& kept = actor.given_up;
    for (const Assignment& assignment : actor.assignments) {
      if (!is_lost(assignment)) continue;
      numbers[id].push_back(assignment.number);
      kept.push_back(assignment);
    }
    std::erase_if(actor.assignments, is_it);
    if (std::ssize(kept) > kGivenUpKept) kept.erase(kept.begin(), kept.end() - kGivenUpKept);
  }
  return numbers;
}

std::uint64_t Roster::idle() const {
  std::uint64_t idle = 0;
  for (const auto& [id, actor] : actors_) {
    idle += actor.envs - std::min<std::uint64_t>(actor.envs, actor.assignments.size());
  }
  return idle;
}

std::optional<std::uint64_t> Roster::LeastLoaded(
    std::uint32_t assignments_per_env,
    const std::function<std::size_t(const Actors::value_type&)>& room) const {
  const Actors::value_type* best = nullptr;
  for (const auto& candidate : actors_) {
    const Actor& actor = candidate.second;
    const std::size_t assignments = actor.assignments.size();
    if (assignments >= std::size_t{actor.envs} * assignments_per_env) continue;
    if (best != nullptr &&
        assignments * best->second.envs >= best->second.assignments.size() * actor.envs) {
      continue;
    }
    if (assignments < room(candidate)) best = &candidate;  // asked last: it may be costly
  }
  return best == nullptr ? std::nullopt : std::optional(best->first);
}

}  // namespace metronome::collect::assignments
