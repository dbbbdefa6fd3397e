#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "learner/collect/assignments/assignment_rules.h"
#include "learner/collect/assignments/idle_time.h"
#include "learner/collect/assignments/number_book.h"
#include "learner/collect/assignments/patience.h"
#include "learner/collect/assignments/roster.h"
#include "learner/collect/trust/trust.h"

namespace metronome::collect::assignments {

/// Numbers to be sent to one actor, all to be played under one weights version.
struct Handout {
  std::uint64_t actor_id = 0;
  std::uint64_t weights_version = 0;
  std::vector<std::uint64_t> numbers;  // in the order to play them
  bool operator==(const Handout&) const = default;
};

/// Decides who plays which episode: open numbers go to the least loaded envs, lowest first, late
/// ones to idle envs too, lost ones to anybody. Pure logic on given time points, which must not
/// decrease; not thread-safe.
class AssignmentPlan {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// @param book   where the numbers are. @param trust  in the actors that join here. Both must
  /// outlive the plan.
  AssignmentPlan(const AssignmentRules& rules, NumberBook* book, collect::trust::Trust* trust);

  /// The actor is there (again) with so many envs; at least 1.
  void Join(std::uint64_t actor_id, const std::string& host, std::uint32_t envs, TimePoint now);
  /// Its missing numbers are open again at once. @return how many assignments that were.
  std::size_t Lose(std::uint64_t actor_id, TimePoint now);
  /// The actor has brought this number, wanted or not: if it was assigned to it, its env is free.
  void Free(std::uint64_t number, std::uint64_t actor_id, TimePoint now);

  /// Hands out what is due. The caller sends it; if that fails, it calls Lose.
  std::vector<Handout> HandOut(TimePoint now);
  /// When HandOut has work to do even if nothing happens; std::nullopt: never.
  [[nodiscard]] std::optional<TimePoint> NextDeadline(TimePoint now) const;

  /// An actor is there that may be asked for a number that was heard, and that answers its
  /// assignments.
  [[nodiscard]] bool HasOther(std::uint64_t number, TimePoint now) const;
  [[nodiscard]] const Roster& roster() const { return roster_; }
  /// Assignments of numbers that had been assigned before, and not for a second opinion.
  [[nodiscard]] std::uint64_t reassigned() const { return reassigned_; }
  /// Share of env time without an assignment since the last call, in [0, 1]; 0 without envs.
  double TakeIdleShare(TimePoint now);

 private:
  using Number = NumberBook::Number;
  using Candidate = Roster::Actors::value_type;
  using MayBeAsked = std::function<bool(const Candidate&, const collect::trust::Trust::State&)>;

  void CountIdle(TimePoint now);
  void GiveUpLost(TimePoint now);
  [[nodiscard]] std::chrono::nanoseconds LostAfter(const Roster::Assignment& assignment) const;
  void AskOthers(TimePoint now, std::vector<Handout>& plan);
  void AskForOpen(TimePoint now, std::vector<Handout>& plan);
  void AskForLate(TimePoint now, std::vector<Handout>& plan);
  [[nodiscard]] std::vector<std::uint64_t> LateEverywhere(TimePoint now) const;
  [[nodiscard]] std::uint32_t AssignmentsPerEnv() const;
  [[nodiscard]] std::optional<std::uint64_t> LeastLoaded(const Number& number,
                                                         std::uint32_t assignments_per_env,
                                                         const MayBeAsked& may_be_asked,
                                                         TimePoint now) const;
  void Ask(std::uint64_t actor_id, std::uint64_t number, TimePoint now, std::vector<Handout>& plan);

  AssignmentRules rules_;
  NumberBook& book_;
  collect::trust::Trust& trust_;
  Roster roster_;
  Patience patience_;
  IdleTime idle_;
  std::uint64_t reassigned_ = 0;
};

}  // namespace metronome::collect::assignments
