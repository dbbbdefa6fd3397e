#include "learner/collect/assignments/assignment_plan.h"

#include <algorithm>
#include <map>

namespace metronome::collect::assignments {

AssignmentPlan::AssignmentPlan(const AssignmentRules& rules, NumberBook* book,
                               collect::trust::Trust* trust)
    : rules_(rules), book_(*book), trust_(*trust), patience_(rules) {}

void AssignmentPlan::Join(std::uint64_t actor_id, const std::string& host, std::uint32_t envs,
                          TimePoint now) {
  CountIdle(now);
  roster_.Join(actor_id, host, envs);
}

std::size_t AssignmentPlan::Lose(std::uint64_t actor_id, TimePoint now) {
  CountIdle(now);
  const std::vector<std::uint64_t> numbers = roster_.Leave(actor_id);
  for (const std::uint64_t number : numbers) book_.TakeBack(number, actor_id);
  return numbers.size();
}

void AssignmentPlan::Free(std::uint64_t number, std::uint64_t actor_id, TimePoint now) {
  CountIdle(now);
  trust_.Brought(actor_id);
  if (const auto took = roster_.Release(actor_id, number, now)) patience_.Learn(*took);
  book_.TakeBack(number, actor_id);
}

std::vector<Handout> AssignmentPlan::HandOut(TimePoint now) {
  CountIdle(now);
  std::vector<Handout> plan;
  GiveUpLost(now);
  AskOthers(now, plan);
  AskForOpen(now, plan);
  AskForLate(now, plan);
  return plan;
}

// An assignment that nothing came of for very long (a sample dropped on the way, an actor that
// hangs) does not block its env for ever. But its actor may merely be slow, so it rests before it
// is asked again: else a machine that is suddenly slower would be buried under repeated
// assignments.
void AssignmentPlan::GiveUpLost(TimePoint now) {
  const auto first_try = patience_.Lost(1);
  const auto is_lost = [&](const Roster::Assignment& assignment) {
    const auto age = now - assignment.since;
    return age >= first_try && age >= LostAfter(assignment);
  };
  for (const auto& [actor_id, numbers] : roster_.GiveUp(is_lost)) {
    for (const std::uint64_t number : numbers) book_.TakeBack(number, actor_id);
    trust_.GaveUp(actor_id, now);
  }
}

std::chrono::nanoseconds AssignmentPlan::LostAfter(const Roster::Assignment& assignment) const {
  const Number* number = book_.Find(assignment.number);
  return patience_.Lost(number == nullptr ? 1 : number->tries);
}

// Near the end no assignment waits in one actor's queue while another's env may fall idle.
std::uint32_t AssignmentPlan::AssignmentsPerEnv() const {
  return book_.open().size() <= roster_.envs() ? 1 : rules_.assignments_per_env;
}

// Whoever is on another host, were it busy or flapping: two processes of one machine may well make
// the same mistake.
void AssignmentPlan::AskOthers(TimePoint now, std::vector<Handout>& plan) {
  const std::set<std::uint64_t> again = book_.open_again();
  for (const std::uint64_t number : again) {
    const Number& entry = *book_.Find(number);
    const auto is_elsewhere = [&](const Candidate& actor) {
      return !entry.WasHeardOn(actor.second.host);
    };
    const bool elsewhere =
        std::any_of(roster_.actors().begin(), roster_.actors().end(), [&](const Candidate& actor) {
          return !trust_.StateOf(actor.first, now).silent && is_elsewhere(actor);
        });
    const auto actor_id = LeastLoaded(
        entry, AssignmentsPerEnv(),
        [&](const Candidate& actor, const collect::trust::Trust::State&) {
          return !elsewhere || is_elsewhere(actor);
        },
        now);
    if (actor_id) Ask(*actor_id, number, now, plan);
  }
}

// An actor that gave up an assignment, or comes and goes, is asked only when nobody else is there.
void AssignmentPlan::AskForOpen(TimePoint now, std::vector<Handout>& plan) {
  const auto& actors = roster_.actors();
  const bool any_reliable = std::any_of(actors.begin(), actors.end(), [&](const Candidate& actor) {
    return trust_.StateOf(actor.first, now).reliable();
  });
  const auto may_be_asked = [&](const Candidate&, const collect::trust::Trust::State& trust) {
    return !any_reliable || trust.reliable();
  };
  while (!book_.open().empty()) {
    const std::uint64_t number = *book_.open().begin();
    const auto actor_id = LeastLoaded(*book_.Find(number), AssignmentsPerEnv(), may_be_asked, now);
    if (!actor_id) return;
    Ask(*actor_id, number, now, plan);
  }
}

// A number that is late at everyone who plays it goes to one more idle env: the first result wins.
// Numbers that wait for another host to play them again may wait for ever: they hold nothing up
// here.
void AssignmentPlan::AskForLate(TimePoint now, std::vector<Handout>& plan) {
  if (!book_.open().empty()) return;
  // Anybody's: the env is idle, and a result that comes twice does no harm.
  const auto anybody = [](const Candidate&, const collect::trust::Trust::State&) { return true; };
  for (const std::uint64_t number : LateEverywhere(now)) {
    const auto actor_id = LeastLoaded(*book_.Find(number), 1, anybody, now);
    if (actor_id) Ask(*actor_id, number, now, plan);
  }
}

std::vector<std::uint64_t> AssignmentPlan::LateEverywhere(TimePoint now) const {
  const auto patience = patience_.Late();
  std::map<std::uint64_t, bool> late;
  for (const auto& actor : roster_.actors()) {
    for (const Roster::Assignment& assignment : actor.second.assignments) {
      const Number* number = book_.Find(assignment.number);
      if (number == nullptr || number->state != Number::State::kOut) continue;
      bool& everywhere = late.emplace(assignment.number, true).first->second;
      everywhere = everywhere && now - assignment.since >= patience;
    }
  }
  std::vector<std::uint64_t> numbers;
  for (const auto& [number, everywhere] : late) {
    if (everywhere) numbers.push_back(number);
  }
  return numbers;
}

// Of those who do not play it yet and may.
std::optional<std::uint64_t> AssignmentPlan::LeastLoaded(const Number& number,
                                                         std::uint32_t assignments_per_env,
                                                         const MayBeAsked& may_be_asked,
                                                         TimePoint now) const {
  return roster_.LeastLoaded(assignments_per_env, [&](const Candidate& actor) -> std::size_t {
    const auto& holders = number.holders;
    const bool plays_it = std::find(holders.begin(), holders.end(), actor.first) != holders.end();
    if (plays_it || !number.MayBePlayedBy(actor.first, actor.second.host)) return 0;
    const collect::trust::Trust::State trust = trust_.StateOf(actor.first, now);
    if (!may_be_asked(actor, trust)) return 0;
    return trust.silent ? 1 : std::size_t{actor.second.envs} * assignments_per_env;
  });
}

void AssignmentPlan::Ask(std::uint64_t actor_id, std::uint64_t number, TimePoint now,
                         std::vector<Handout>& plan) {
  const bool first = book_.HandOut(number, {actor_id, roster_.actors().at(actor_id).host});
  if (!first) ++reassigned_;
  roster_.Give(actor_id, number, now);
  const std::uint64_t version = BehaviourVersion(rules_, number);
  const auto same = std::find_if(plan.begin(), plan.end(), [&](const Handout& handout) {
    return handout.actor_id == actor_id && handout.weights_version == version;
  });
  if (same != plan.end()) {
    same->numbers.push_back(number);
  } else {
    plan.push_back({actor_id, version, {number}});
  }
}

std::optional<AssignmentPlan::TimePoint> AssignmentPlan::NextDeadline(TimePoint now) const {
  std::optional<TimePoint> next = trust_.NextDeadline(now);
  for (const auto& actor : roster_.actors()) {
    for (const Roster::Assignment& assignment : actor.second.assignments) {
      // A late assignment without an idle env waits for an event, not for time: then the loss is
      // next.
      TimePoint due = assignment.since + patience_.Late();
      if (due <= now) due = assignment.since + LostAfter(assignment);
      if (!next || due < *next) next = due;
    }
  }
  return next;
}

bool AssignmentPlan::HasOther(std::uint64_t number, TimePoint now) const {
  const Number* entry = book_.Find(number);
  const auto& actors = roster_.actors();
  return std::any_of(actors.begin(), actors.end(), [&](const Candidate& actor) {
    return !trust_.StateOf(actor.first, now).silent &&
           entry->MayBePlayedBy(actor.first, actor.second.host);
  });
}

void AssignmentPlan::CountIdle(TimePoint now) { idle_.Count(roster_.envs(), roster_.idle(), now); }

double AssignmentPlan::TakeIdleShare(TimePoint now) {
  CountIdle(now);
  return idle_.TakeShare();
}

}  // namespace metronome::collect::assignments
