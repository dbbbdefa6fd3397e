#include "learner/collect/assignments/assignment_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <map>
#include <queue>
#include <random>
#include <set>

#include "tests/unit/support/assignment_rules.h"

namespace metronome::collect::assignments {
namespace {

using std::chrono::milliseconds;
using test::Rules;
using Standing = NumberBook::Claim::Standing;
using Numbers = std::vector<std::uint64_t>;

AssignmentPlan::TimePoint At(int ms) { return AssignmentPlan::TimePoint{} + milliseconds(ms); }

Numbers NumbersOf(const std::vector<Handout>& plan, std::uint64_t actor) {
  Numbers numbers;
  for (const Handout& handout : plan) {
    if (handout.actor_id != actor) continue;
    numbers.insert(numbers.end(), handout.numbers.begin(), handout.numbers.end());
  }
  return numbers;
}

Numbers AllNumbers(const std::vector<Handout>& plan) {
  Numbers numbers;
  for (const Handout& handout : plan) {
    numbers.insert(numbers.end(), handout.numbers.begin(), handout.numbers.end());
  }
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

/// The plan and what it works on, as the collector uses them.
struct Assignments {
  explicit Assignments(const AssignmentRules& assignment_rules,
                       const collect::trust::TrustRules& trust_rules = {})
      : rules(assignment_rules), trust(trust_rules, {}), book(rules), plan(rules, &book, &trust) {}

  void Join(std::uint64_t actor, const std::string& host, std::uint32_t envs,
            AssignmentPlan::TimePoint now) {
    trust.Join(actor, host, now);
    plan.Join(actor, host, envs, now);
  }
  void Lose(std::uint64_t actor, AssignmentPlan::TimePoint now) {
    trust.Lose(actor, now);
    plan.Lose(actor, now);
  }
  Standing StandingOf(std::uint64_t number, std::uint64_t actor) const {
    return book.ClaimOf(number, actor).standing;
  }
  void Arrive(std::uint64_t number, std::uint64_t actor, AssignmentPlan::TimePoint now) {
    book.Arrive(number);
    plan.Free(number, actor, now);
  }
  /// Somebody on another host is to play it too.
  void Hear(std::uint64_t number, std::uint64_t actor, const std::string& host, bool disputed,
            AssignmentPlan::TimePoint now) {
    Arrive(number, actor, now);
    book.AskAnother(number, {actor, host}, disputed);
  }
  bool IsComplete(std::uint64_t batch) const {
    return book.AcceptedOf(batch) == rules.episodes_per_update;
  }

  AssignmentRules rules;
  collect::trust::Trust trust;
  NumberBook book;
  AssignmentPlan plan;
};

void Bring(Assignments& assignments, std::uint64_t number, std::uint64_t actor, int ms) {
  ASSERT_EQ(assignments.StandingOf(number, actor), Standing::kWanted) << number;
  assignments.Arrive(number, actor, At(ms));
  assignments.book.Accept(number, {"host"});
}

TEST(AssignmentPlanTest, TwoAssignmentsPerEnvAreInFlightLowestNumbersFirstSpreadFairly) {
  Assignments assignments(Rules(16, 1));
  assignments.Join(1, "a", 1, At(0));
  assignments.Join(2, "b", 2, At(0));
  const auto plan = assignments.plan.HandOut(At(0));
  EXPECT_EQ(AllNumbers(plan), (Numbers{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(NumbersOf(plan, 1), (Numbers{0, 3}));
  EXPECT_EQ(NumbersOf(plan, 2), (Numbers{1, 2, 4, 5}));
  EXPECT_TRUE(assignments.plan.HandOut(At(1)).empty());
}

TEST(AssignmentPlanTest, AFreedEnvGetsTheNextNumberAtOnce) {
  Assignments assignments(Rules(16, 1));
  assignments.Join(1, "a", 1, At(0));
  assignments.plan.HandOut(At(0));
  assignments.Arrive(0, 1, At(10));  // not judged yet
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(10)), 1), (Numbers{2}));
}

TEST(AssignmentPlanTest, NearTheEndNobodyQueuesWhileAnotherEnvMayFallIdle) {
  Assignments assignments(Rules(5, 1));
  assignments.Join(1, "a", 1, At(0));
  assignments.Join(2, "b", 1, At(0));
  // 5 numbers, 2 envs: three go out, the last two wait for whoever is free first.
  EXPECT_EQ(AllNumbers(assignments.plan.HandOut(At(0))), (Numbers{0, 1, 2}));
  Bring(assignments, 1, 2, 10);  // actor 2 had one assignment and is idle now
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(10)), 2), (Numbers{3}));
  Bring(assignments, 3, 2, 20);
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(20)), 2), (Numbers{4}));
}

TEST(AssignmentPlanTest, OnlyBatchesWhoseBehaviourVersionExistsAreAssigned) {
  Assignments assignments(Rules(2, 3));
  assignments.Join(1, "a", 4, At(0));
  EXPECT_EQ(AllNumbers(assignments.plan.HandOut(At(0))), (Numbers{0, 1}));
  EXPECT_EQ(assignments.StandingOf(2, 1), Standing::kNotAssigned);
  Bring(assignments, 0, 1, 10);
  EXPECT_FALSE(assignments.IsComplete(0));
  EXPECT_THROW(assignments.book.Publish(1), std::logic_error);
  Bring(assignments, 1, 1, 12);
  EXPECT_TRUE(assignments.IsComplete(0));
  EXPECT_TRUE(assignments.plan.HandOut(At(12)).empty());
  assignments.book.Publish(1);
  const auto plan = assignments.plan.HandOut(At(20));
  ASSERT_EQ(plan.size(), 1U);
  EXPECT_EQ(plan[0], (Handout{1, 1, {2, 3}}));
}

TEST(AssignmentPlanTest, OverlapOneAssignmentsTheNextBatchUnderTheWeightsThatAreBeingImproved) {
  Assignments assignments(Rules(2, 4, 1));
  assignments.Join(1, "a", 8, At(0));
  EXPECT_EQ(assignments.plan.HandOut(At(0)), (std::vector<Handout>{{1, 0, {0, 1, 2, 3}}}));
  for (const std::uint64_t number : {2, 0, 1, 3}) Bring(assignments, number, 1, 10);
  EXPECT_TRUE(assignments.plan.HandOut(At(10)).empty());
  assignments.book.Publish(1);
  EXPECT_EQ(assignments.plan.HandOut(At(20)), (std::vector<Handout>{{1, 1, {4, 5}}}));
  assignments.book.Publish(2);  // batch 1 was there already
  EXPECT_EQ(assignments.plan.HandOut(At(30)), (std::vector<Handout>{{1, 2, {6, 7}}}));
  EXPECT_EQ(assignments.StandingOf(8, 1), Standing::kNotAssigned);
}

TEST(AssignmentPlanTest, AResumedRunWithOverlapAssignmentsTheBatchOfTheVersionBeforeToo) {
  AssignmentRules rules = Rules(2, 9, 1);
  rules.first_version = 5;
  Assignments assignments(rules);
  assignments.Join(1, "a", 8, At(0));
  EXPECT_EQ(assignments.plan.HandOut(At(0)),
            (std::vector<Handout>{{1, 4, {10, 11}}, {1, 5, {12, 13}}}));
  EXPECT_EQ(assignments.StandingOf(9, 1), Standing::kDuplicate);
}

TEST(AssignmentPlanTest, ALostActorsAssignmentsGoBackAtOnce) {
  Assignments assignments(Rules(8, 1));
  assignments.Join(1, "a", 1, At(0));
  assignments.plan.HandOut(At(0));
  assignments.Join(2, "b", 4, At(1));
  EXPECT_EQ(AllNumbers(assignments.plan.HandOut(At(1))), (Numbers{2, 3, 4, 5}));
  assignments.Lose(1, At(2));
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(2)), 2),
            Numbers{});  // its four envs are busy: a tail
  Bring(assignments, 2, 2, 3);
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(3)), 2), (Numbers{0}));
  EXPECT_EQ(assignments.plan.reassigned(), 1U);
  EXPECT_EQ(assignments.plan.roster().actors().size(), 1U);
  // An episode that the lost one still brings is as good as any.
  EXPECT_EQ(assignments.StandingOf(0, 1), Standing::kWanted);
}

TEST(AssignmentPlanTest, ALateAssignmentGoesToAnotherIdleEnvAndTheFirstResultWins) {
  Assignments assignments(Rules(6, 2));
  assignments.Join(1, "slow", 1, At(0));
  assignments.Join(2, "fast", 1, At(0));
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(0)), 1), (Numbers{0, 2}));
  int now = 0;
  for (const std::uint64_t number : {1, 3, 4, 5}) {
    Bring(assignments, number, 2, now += 400);
    assignments.plan.HandOut(At(now));
  }
  // At 1600 the fast one is idle; 0 and 2 have been out for four medians each.
  EXPECT_EQ(assignments.plan.reassigned(), 1U);
  EXPECT_EQ(assignments.StandingOf(0, 2), Standing::kWanted);
  Bring(assignments, 0, 2, 2000);
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(2000)), 2), (Numbers{2}));
  EXPECT_EQ(assignments.StandingOf(0, 1), Standing::kDuplicate);
  assignments.plan.Free(0, 1, At(2001));
  Bring(assignments, 2, 1, 2010);
  EXPECT_TRUE(assignments.IsComplete(0));
}

TEST(AssignmentPlanTest, NothingIsLateBeforeThreeMediansHavePassed) {
  Assignments assignments(Rules(3, 1));
  assignments.Join(1, "slow", 1, At(0));
  assignments.Join(2, "fast", 1, At(0));
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(0)), 1), (Numbers{0}));
  Bring(assignments, 1, 2, 400);
  assignments.plan.HandOut(At(400));
  Bring(assignments, 2, 2, 800);
  EXPECT_TRUE(assignments.plan.HandOut(At(1199)).empty());
  EXPECT_EQ(*assignments.plan.NextDeadline(At(1199)), At(1200));
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(1200)), 2), (Numbers{0}));
  EXPECT_TRUE(assignments.plan.HandOut(At(1201)).empty());  // it is not late at its second player
}

TEST(AssignmentPlanTest, WaitingInAnActorsQueueIsNotPlaying) {
  Assignments assignments(Rules(20, 1));
  assignments.Join(1, "steady", 1, At(0));
  assignments.plan.HandOut(At(0));
  for (const std::uint64_t number : {0, 1}) {
    const int now = 400 * int(number + 1);
    Bring(assignments, number, 1, now);
    assignments.plan.HandOut(At(now));
  }
  // Both took 400 ms; number 2, sent at 400, has been played since 800 only.
  EXPECT_EQ(*assignments.plan.NextDeadline(At(800)), At(800 + 3 * 400));
}

TEST(AssignmentPlanTest, ALateAssignmentIsNotGivenToTheOneThatPlaysItAlready) {
  Assignments assignments(Rules(2, 1));
  assignments.Join(1, "two envs", 2, At(0));
  EXPECT_EQ(AllNumbers(assignments.plan.HandOut(At(0))), (Numbers{0, 1}));
  Bring(assignments, 1, 1, 400);
  EXPECT_TRUE(assignments.plan.HandOut(At(3599)).empty());
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(3600)), 1),
            (Numbers{0}));  // nine medians: it is lost
}

TEST(AssignmentPlanTest, ASampleLostOnTheWayIsReassignedEvenFromTheOnlyActor) {
  Assignments assignments(Rules(3, 1));
  assignments.Join(1, "only", 1, At(0));
  EXPECT_EQ(AllNumbers(assignments.plan.HandOut(At(0))), (Numbers{0, 1}));
  Bring(assignments, 1, 1, 300);  // 0 never comes
  AssignmentPlan::TimePoint now = At(300);
  std::vector<Handout> plan = assignments.plan.HandOut(now);
  for (int i = 0; i < 3 && plan.empty(); ++i) {
    const auto deadline = assignments.plan.NextDeadline(now);
    ASSERT_TRUE(deadline.has_value());
    ASSERT_GT(*deadline, now) << "a deadline in the past would spin";
    now = *deadline;
    plan = assignments.plan.HandOut(now);
  }
  EXPECT_EQ(NumbersOf(plan, 1), (Numbers{0}));
  EXPECT_EQ(now, At(2700));  // nine medians
}

TEST(AssignmentPlanTest, AnActorThatHangsIsTriedAgainEverLessOftenAndWithOneAssignment) {
  Assignments assignments(Rules(40, 1));
  assignments.Join(1, "hangs", 1, At(0));
  assignments.Join(2, "works", 1, At(0));
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(0)), 1), (Numbers{0, 2}));
  int now = 0;
  Numbers brought_by_2{1, 3};
  std::vector<int> asked_of_1_at;
  for (std::size_t i = 0; i < brought_by_2.size() && now < 40000; ++i) {
    Bring(assignments, brought_by_2[i], 2, now += 300);
    const auto plan = assignments.plan.HandOut(At(now));
    for (const auto number : NumbersOf(plan, 2)) brought_by_2.push_back(number);
    for ([[maybe_unused]] const auto number : NumbersOf(plan, 1)) asked_of_1_at.push_back(now);
  }
  EXPECT_TRUE(assignments.IsComplete(0));
  // Assignments are lost after 2700 ms (nine medians of 300), the rest after it is 1 s, 2 s, ...
  EXPECT_EQ(asked_of_1_at, (std::vector<int>{3900, 8700}));
}

TEST(AssignmentPlanTest, AnActorThatWasMerelySlowWorksOnOnceItSpeaks) {
  Assignments assignments(Rules(40, 1));
  assignments.Join(1, "slow", 1, At(0));
  assignments.Join(2, "fast", 1, At(0));
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(0)), 1), (Numbers{0, 2}));
  Numbers brought_by_2{1, 3};
  int now = 0;
  for (std::size_t i = 0; now < 3300; ++i) {
    Bring(assignments, brought_by_2[i], 2, now += 300);
    const auto plan = assignments.plan.HandOut(At(now));
    for (const auto number : NumbersOf(plan, 2)) brought_by_2.push_back(number);
    EXPECT_TRUE(NumbersOf(plan, 1).empty()) << now;
  }
  // The episode that it was given up for comes, a duplicate: it gets assignments at once, two for
  // its env.
  EXPECT_EQ(assignments.StandingOf(0, 1), Standing::kDuplicate);
  assignments.plan.Free(0, 1, At(3310));
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(3310)), 1).size(), 2U);
}

TEST(AssignmentPlanTest, WhatIsLateIsAskedEvenOfAnActorThatRests) {
  collect::trust::TrustRules trust;
  trust.first_rest = milliseconds(50000);
  Assignments assignments(Rules(2, 1), trust);
  assignments.Join(1, "hangs", 1, At(0));
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(0)), 1), (Numbers{0}));
  EXPECT_TRUE(assignments.plan.HandOut(At(17999)).empty());
  assignments.Join(2, "works", 1, At(18000));
  const auto plan = assignments.plan.HandOut(At(18000));  // lost at 1, which rests now
  EXPECT_EQ(NumbersOf(plan, 2), (Numbers{0}));
  EXPECT_TRUE(NumbersOf(plan, 1).empty());
  Bring(assignments, 0, 2, 18400);
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(18400)), 2), (Numbers{1}));
  EXPECT_TRUE(assignments.plan.HandOut(At(19599)).empty());
  // Three medians of 400 later it is late, and 1 has an idle env.
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(19600)), 1), (Numbers{1}));
}

// Fifteen times slower all of a sudden: what is repeated stays within bounds, the estimate adapts.
TEST(AssignmentPlanTest, ASuddenSlownessOfEverybodyDoesNotBuryThemUnderRepeatedAssignments) {
  Assignments assignments(Rules(200, 1));
  assignments.Join(1, "a", 1, At(0));
  assignments.Join(2, "b", 1, At(0));
  std::map<std::uint64_t, std::deque<std::uint64_t>> queues;  // of each actor, oldest first
  std::map<std::uint64_t, int> free_at{{1, 0}, {2, 0}};
  for (int now = 0; !assignments.IsComplete(0) && now < 400'000; now += 10) {
    for (const auto& handout : assignments.plan.HandOut(At(now))) {
      for (const auto number : handout.numbers) queues[handout.actor_id].push_back(number);
    }
    for (auto& [actor, queue] : queues) {
      if (queue.empty() || now < free_at[actor]) continue;
      const std::uint64_t number = queue.front();
      queue.pop_front();
      if (assignments.StandingOf(number, actor) == Standing::kWanted) {
        Bring(assignments, number, actor, now);
      } else {
        assignments.plan.Free(number, actor, At(now));
      }
      free_at[actor] = now + (now < 3000 ? 100 : 1500);
    }
  }
  EXPECT_TRUE(assignments.IsComplete(0));
  EXPECT_LT(assignments.plan.reassigned(), 60U);
}

TEST(AssignmentPlanTest, AnActorThatIsNotTrustedYetIsAskedOnlyIfNobodyElseIsThere) {
  collect::trust::TrustRules trust;
  trust.flaps.allowed = 0;
  trust.flaps.first = milliseconds(5000);
  Assignments assignments(Rules(8, 1), trust);
  assignments.Join(1, "flaps", 1, At(0));
  assignments.Lose(1, At(0));
  assignments.Join(1, "flaps", 1, At(0));
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(0)), 1), (Numbers{0, 1}));
  assignments.plan.Lose(1, At(10));  // it cannot be reached for a moment
  assignments.Join(2, "steady", 1, At(20));
  assignments.Join(1, "flaps", 1, At(20));
  EXPECT_EQ(AllNumbers(assignments.plan.HandOut(At(20))), (Numbers{0, 1}));
  EXPECT_EQ(assignments.plan.NextDeadline(At(4000)),
            At(5000));  // by when 2's assignments are long late
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(5000)), 1), (Numbers{2, 3}));
}

TEST(AssignmentPlanTest, ARejectedEpisodeIsReassigned) {
  Assignments assignments(Rules(2, 1));
  assignments.Join(1, "a", 1, At(0));
  assignments.plan.HandOut(At(0));
  assignments.Arrive(0, 1, At(10));
  assignments.book.PutBack(0);
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(10)), 1), (Numbers{0}));
  EXPECT_EQ(assignments.plan.reassigned(), 1U);
}

// Number 0 is in dispute between the only two hosts, and waits for a third one.
TEST(AssignmentPlanTest, WhatIsLateIsAskedOfAnotherThoughADisputeWaits) {
  Assignments assignments(Rules(3, 1));
  assignments.Join(1, "a", 1, At(0));
  assignments.Join(2, "b", 1, At(0));
  EXPECT_EQ(AllNumbers(assignments.plan.HandOut(At(0))), (Numbers{0, 1}));
  assignments.Hear(0, 1, "a", false, At(400));
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(400)), 1), (Numbers{2}));  // 2 is busy with 1
  Bring(assignments, 1, 2, 401);
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(401)), 2), (Numbers{0}));
  assignments.Hear(0, 2, "b", true, At(800));
  EXPECT_EQ(assignments.book.open_again(), (std::set<std::uint64_t>{0}));
  EXPECT_TRUE(assignments.plan.HandOut(At(1500)).empty());
  // Three medians of 400 after 1 was asked for it, and 2 has an idle env.
  EXPECT_EQ(assignments.plan.NextDeadline(At(1500)), At(1600));
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(1600)), 2), (Numbers{2}));
}

// As AFreedEnv..., NearTheEnd...: what nobody here may play is no work that is left.
TEST(AssignmentPlanTest, NearTheEndNobodyQueuesThoughDisputesWait) {
  Assignments assignments(Rules(6, 1));
  assignments.Join(1, "a", 2, At(0));
  EXPECT_EQ(AllNumbers(assignments.plan.HandOut(At(0))), (Numbers{0, 1, 2, 3}));
  for (const std::uint64_t number : {0, 1}) assignments.Hear(number, 1, "a", true, At(100));
  assignments.Join(2, "a", 2, At(100));
  // 4 and 5 are left for four envs, of which two are free.
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(100)), 2), (Numbers{4, 5}));
  assignments.Lose(2, At(110));
  EXPECT_TRUE(assignments.plan.HandOut(At(110)).empty()) << "queued behind what is being played";
}

TEST(AssignmentPlanTest, AnotherHostIsAskedForASecondOpinionIfOneIsThere) {
  Assignments assignments(Rules(2, 1));
  assignments.Join(1, "a", 1, At(0));
  assignments.plan.HandOut(At(0));
  assignments.Join(2, "a", 1, At(1));
  assignments.Join(3, "b", 1, At(1));
  assignments.Hear(0, 1, "a", false, At(10));
  EXPECT_TRUE(assignments.plan.HasOther(0, At(10)));
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(10)), 3), (Numbers{0}));
  assignments.Lose(3, At(20));
  EXPECT_EQ(NumbersOf(assignments.plan.HandOut(At(20)), 2), (Numbers{0}));
  assignments.Lose(2, At(30));
  EXPECT_FALSE(assignments.plan.HasOther(0, At(30)));
}

TEST(AssignmentPlanTest, TheIdleShareIsEnvTimeWithoutAnAssignment) {
  Assignments assignments(Rules(1, 2));
  assignments.Join(1, "a", 2, At(0));
  assignments.plan.HandOut(At(0));
  Bring(assignments, 0, 1, 300);
  // 2 envs for 400 ms: one idle throughout, the other for the last 100 ms.
  EXPECT_DOUBLE_EQ(assignments.plan.TakeIdleShare(At(400)), 500.0 / 800.0);
  EXPECT_DOUBLE_EQ(assignments.plan.TakeIdleShare(At(500)), 1.0);
}

// A world of actors that join, die, hang, lose, repeat and falsify, against the assignments.
class Simulation {
 public:
  Simulation(unsigned seed, std::uint64_t overlap) : random_(seed), rules_(Rules(12, 6, overlap)) {
    trust_.bad_answers_allowed = 50;
  }

  // @return how often each number was accepted.
  std::map<std::uint64_t, int> Run() {
    Assignments assignments(rules_, trust_);
    assignments_ = &assignments;
    for (int i = 0; i < 3; ++i) JoinOne();
    while (version_ < rules_.updates_total && now_ < 100'000'000) Step();
    EXPECT_EQ(version_, rules_.updates_total) << "it hangs";
    return accepted_;
  }

 private:
  struct Event {
    int at;
    std::uint64_t actor;
    std::uint64_t number;
    bool operator>(const Event& other) const { return at > other.at; }
  };

  int Draw(int bound) { return int(random_() % unsigned(bound)); }

  void JoinOne() {
    const std::uint64_t id = next_actor_++;
    alive_.insert(id);
    assignments_->Join(id, "actor", 1 + unsigned(Draw(3)), At(now_));
  }

  void SendAssignments() {
    for (const Handout& handout : assignments_->plan.HandOut(At(now_))) {
      for (const std::uint64_t number : handout.numbers) {
        EXPECT_EQ(handout.weights_version, BehaviourVersion(rules_, number));
        EXPECT_LE(handout.weights_version, version_) << "weights that do not exist yet";
        if (Draw(10) == 0) continue;  // lost on the way
        const int duration = Draw(12) == 0 ? 5000 : 200 + Draw(200);
        busy_until_[handout.actor_id] = std::max(busy_until_[handout.actor_id], now_) + duration;
        events_.push({busy_until_[handout.actor_id], handout.actor_id, number});
        if (Draw(10) == 0) events_.push({now_ + duration + Draw(3000), handout.actor_id, number});
      }
    }
  }

  void Step() {
    SendAssignments();
    const auto deadline = assignments_->plan.NextDeadline(At(now_));
    const int due = deadline ? int((*deadline - At(0)) / milliseconds(1)) + 1 : now_ + 100;
    if (events_.empty() || events_.top().at > due) {
      now_ = std::max(now_, due);
    } else {
      const Event event = events_.top();
      events_.pop();
      now_ = std::max(now_, event.at);
      Receive(event);
    }
    if (Draw(25) == 0 || alive_.empty()) JoinOne();
    if (Draw(25) == 0) KillOne();
    while (version_ < rules_.updates_total && assignments_->IsComplete(version_)) {
      assignments_->book.Publish(++version_);
    }
  }

  void KillOne() {
    if (alive_.empty()) return;
    const auto victim = std::next(alive_.begin(), Draw(int(alive_.size())));
    assignments_->Lose(*victim, At(now_));
    alive_.erase(victim);  // what it sent before may still arrive
  }

  void Receive(const Event& event) {
    switch (assignments_->StandingOf(event.number, event.actor)) {
      case Standing::kWanted:
        assignments_->Arrive(event.number, event.actor, At(now_));
        if (Draw(8) == 0) {
          assignments_->book.PutBack(event.number);
          if (!assignments_->trust.Checked(event.actor, false))
            assignments_->plan.Lose(event.actor, At(now_));
        } else {
          assignments_->trust.Checked(event.actor, true);
          assignments_->book.Accept(event.number, {"host"});
          ++accepted_[event.number];
        }
        break;
      case Standing::kDuplicate:
        assignments_->plan.Free(event.number, event.actor, At(now_));
        break;
      case Standing::kNotAssigned:
        ADD_FAILURE() << "assigned, and now unknown: " << event.number;
    }
  }

  std::mt19937 random_;
  AssignmentRules rules_;
  collect::trust::TrustRules trust_;
  Assignments* assignments_ = nullptr;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  std::map<std::uint64_t, int> accepted_;
  std::map<std::uint64_t, int> busy_until_;
  std::set<std::uint64_t> alive_;
  std::uint64_t next_actor_ = 1;
  std::uint64_t version_ = 0;
  int now_ = 0;
};

TEST(AssignmentPlanTest, WhateverActorsDoEachNumberIsAcceptedExactlyOnceAndTheRunEnds) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const auto accepted = Simulation(seed, seed % 2).Run();
    ASSERT_EQ(accepted.size(), 72U) << "seed " << seed;
    for (const auto& [number, times] : accepted) {
      ASSERT_EQ(times, 1) << "number " << number << ", seed " << seed;
    }
  }
}

}  // namespace
}  // namespace metronome::collect::assignments
