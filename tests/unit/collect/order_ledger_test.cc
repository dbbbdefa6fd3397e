#include "learner/collect/order_ledger.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <map>
#include <queue>
#include <random>
#include <set>

namespace metronome {
namespace {

using std::chrono::milliseconds;
using Standing = OrderLedger::Standing;
using Numbers = std::vector<std::uint64_t>;

OrderLedger::TimePoint At(int ms) { return OrderLedger::TimePoint{} + milliseconds(ms); }

OrderRules Rules(std::uint64_t episodes, std::uint64_t updates, std::uint64_t overlap = 0) {
  OrderRules rules;
  rules.episodes_per_update = episodes;
  rules.updates_total = updates;
  rules.overlap = overlap;
  return rules;
}

Numbers NumbersOf(const std::vector<Assignment>& plan, std::uint64_t actor) {
  Numbers numbers;
  for (const Assignment& assignment : plan) {
    if (assignment.actor_id != actor) continue;
    numbers.insert(numbers.end(), assignment.numbers.begin(), assignment.numbers.end());
  }
  return numbers;
}

Numbers AllNumbers(const std::vector<Assignment>& plan) {
  Numbers numbers;
  for (const Assignment& assignment : plan) {
    numbers.insert(numbers.end(), assignment.numbers.begin(), assignment.numbers.end());
  }
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

void Bring(OrderLedger& ledger, std::uint64_t number, std::uint64_t actor, int ms) {
  ASSERT_EQ(ledger.StandingOf(number, actor), Standing::kWanted) << number;
  ledger.Arrive(number, actor, At(ms));
  ledger.Accept(number, actor);
}

TEST(OrderLedgerTest, TwoOrdersPerSlotAreInFlightLowestNumbersFirstSpreadFairly) {
  OrderLedger ledger(Rules(16, 1));
  ledger.Join(1, "a", 1, At(0));
  ledger.Join(2, "b", 2, At(0));
  const auto plan = ledger.Plan(At(0));
  EXPECT_EQ(AllNumbers(plan), (Numbers{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(NumbersOf(plan, 1), (Numbers{0, 3}));
  EXPECT_EQ(NumbersOf(plan, 2), (Numbers{1, 2, 4, 5}));
  EXPECT_TRUE(ledger.Plan(At(1)).empty());
}

TEST(OrderLedgerTest, AFreedSlotGetsTheNextNumberAtOnce) {
  OrderLedger ledger(Rules(16, 1));
  ledger.Join(1, "a", 1, At(0));
  ledger.Plan(At(0));
  ledger.Arrive(0, 1, At(10));  // not judged yet
  EXPECT_EQ(NumbersOf(ledger.Plan(At(10)), 1), (Numbers{2}));
}

TEST(OrderLedgerTest, NearTheEndNobodyQueuesWhileAnotherSlotMayFallIdle) {
  OrderLedger ledger(Rules(5, 1));
  ledger.Join(1, "a", 1, At(0));
  ledger.Join(2, "b", 1, At(0));
  // 5 numbers, 2 slots: three go out, the last two wait for whoever is free first.
  EXPECT_EQ(AllNumbers(ledger.Plan(At(0))), (Numbers{0, 1, 2}));
  Bring(ledger, 1, 2, 10);  // actor 2 had one order and is idle now
  EXPECT_EQ(NumbersOf(ledger.Plan(At(10)), 2), (Numbers{3}));
  Bring(ledger, 3, 2, 20);
  EXPECT_EQ(NumbersOf(ledger.Plan(At(20)), 2), (Numbers{4}));
}

TEST(OrderLedgerTest, OnlyBatchesWhoseBehaviourVersionExistsAreOrdered) {
  OrderLedger ledger(Rules(2, 3));
  ledger.Join(1, "a", 4, At(0));
  EXPECT_EQ(AllNumbers(ledger.Plan(At(0))), (Numbers{0, 1}));
  EXPECT_EQ(ledger.StandingOf(2, 1), Standing::kNotOrdered);
  Bring(ledger, 0, 1, 10);
  EXPECT_FALSE(ledger.IsComplete(0));
  EXPECT_THROW(ledger.Publish(1, At(11)), std::logic_error);
  Bring(ledger, 1, 1, 12);
  EXPECT_TRUE(ledger.IsComplete(0));
  EXPECT_TRUE(ledger.Plan(At(12)).empty());
  ledger.Publish(1, At(20));
  const auto plan = ledger.Plan(At(20));
  ASSERT_EQ(plan.size(), 1U);
  EXPECT_EQ(plan[0], (Assignment{1, 1, {2, 3}}));
}

TEST(OrderLedgerTest, OverlapOneOrdersTheNextBatchUnderTheWeightsThatAreBeingImproved) {
  OrderLedger ledger(Rules(2, 4, 1));
  ledger.Join(1, "a", 8, At(0));
  EXPECT_EQ(ledger.Plan(At(0)), (std::vector<Assignment>{{1, 0, {0, 1, 2, 3}}}));
  for (const std::uint64_t number : {2, 0, 1, 3}) Bring(ledger, number, 1, 10);
  EXPECT_TRUE(ledger.Plan(At(10)).empty());
  ledger.Publish(1, At(20));
  EXPECT_EQ(ledger.Plan(At(20)), (std::vector<Assignment>{{1, 1, {4, 5}}}));
  ledger.Publish(2, At(30));  // batch 1 was there already
  EXPECT_EQ(ledger.Plan(At(30)), (std::vector<Assignment>{{1, 2, {6, 7}}}));
  EXPECT_EQ(ledger.StandingOf(8, 1), Standing::kNotOrdered);
}

TEST(OrderLedgerTest, AResumedRunWithOverlapOrdersTheBatchOfTheVersionBeforeToo) {
  OrderRules rules = Rules(2, 9, 1);
  rules.first_version = 5;
  OrderLedger ledger(rules);
  ledger.Join(1, "a", 8, At(0));
  EXPECT_EQ(ledger.Plan(At(0)), (std::vector<Assignment>{{1, 4, {10, 11}}, {1, 5, {12, 13}}}));
  EXPECT_EQ(ledger.StandingOf(9, 1), Standing::kDuplicate);
}

TEST(OrderLedgerTest, ALostActorsOrdersGoBackAtOnce) {
  OrderLedger ledger(Rules(8, 1));
  ledger.Join(1, "a", 1, At(0));
  ledger.Plan(At(0));
  ledger.Join(2, "b", 4, At(1));
  EXPECT_EQ(AllNumbers(ledger.Plan(At(1))), (Numbers{2, 3, 4, 5}));
  ledger.Lose(1, At(2));
  EXPECT_EQ(NumbersOf(ledger.Plan(At(2)), 2), Numbers{});  // its four slots are busy: a tail
  Bring(ledger, 2, 2, 3);
  EXPECT_EQ(NumbersOf(ledger.Plan(At(3)), 2), (Numbers{0}));
  EXPECT_EQ(ledger.counts().reordered, 1U);
  EXPECT_EQ(ledger.actors(), 1U);
  // What the lost one still brings is as good as any.
  EXPECT_EQ(ledger.StandingOf(0, 1), Standing::kWanted);
}

TEST(OrderLedgerTest, ALateOrderGoesToAnotherIdleSlotAndTheFirstResultWins) {
  OrderLedger ledger(Rules(6, 2));
  ledger.Join(1, "slow", 1, At(0));
  ledger.Join(2, "fast", 1, At(0));
  EXPECT_EQ(NumbersOf(ledger.Plan(At(0)), 1), (Numbers{0, 2}));
  int now = 0;
  for (const std::uint64_t number : {1, 3, 4, 5}) {
    Bring(ledger, number, 2, now += 400);
    ledger.Plan(At(now));
  }
  // At 1600 the fast one is idle; 0 and 2 have been out for four medians each.
  EXPECT_EQ(ledger.counts().reordered, 1U);
  EXPECT_EQ(ledger.StandingOf(0, 2), Standing::kWanted);
  Bring(ledger, 0, 2, 2000);
  EXPECT_EQ(NumbersOf(ledger.Plan(At(2000)), 2), (Numbers{2}));
  EXPECT_EQ(ledger.StandingOf(0, 1), Standing::kDuplicate);
  ledger.ArriveAgain(0, 1, false, At(2001));
  EXPECT_EQ(ledger.counts().duplicates, 1U);
  EXPECT_EQ(ledger.counts().differing_duplicates, 0U);
  Bring(ledger, 2, 1, 2010);
  EXPECT_TRUE(ledger.IsComplete(0));
}

TEST(OrderLedgerTest, NothingIsLateBeforeThreeMediansHavePassed) {
  OrderLedger ledger(Rules(3, 1));
  ledger.Join(1, "slow", 1, At(0));
  ledger.Join(2, "fast", 1, At(0));
  EXPECT_EQ(NumbersOf(ledger.Plan(At(0)), 1), (Numbers{0}));
  Bring(ledger, 1, 2, 400);
  ledger.Plan(At(400));
  Bring(ledger, 2, 2, 800);
  EXPECT_TRUE(ledger.Plan(At(1199)).empty());
  EXPECT_EQ(*ledger.NextDeadline(At(1199)), At(1200));
  EXPECT_EQ(NumbersOf(ledger.Plan(At(1200)), 2), (Numbers{0}));
  EXPECT_TRUE(ledger.Plan(At(1201)).empty());  // it is not late at its second player
}

TEST(OrderLedgerTest, WaitingInAnActorsQueueIsNotPlaying) {
  OrderLedger ledger(Rules(20, 1));
  ledger.Join(1, "steady", 1, At(0));
  ledger.Plan(At(0));
  for (const std::uint64_t number : {0, 1}) {
    const int now = 400 * int(number + 1);
    Bring(ledger, number, 1, now);
    ledger.Plan(At(now));
  }
  // Both took 400 ms; number 2, sent at 400, has been played since 800 only.
  EXPECT_EQ(*ledger.NextDeadline(At(800)), At(800 + 3 * 400));
}

TEST(OrderLedgerTest, ALateOrderIsNotGivenToTheOneThatPlaysItAlready) {
  OrderLedger ledger(Rules(2, 1));
  ledger.Join(1, "two slots", 2, At(0));
  EXPECT_EQ(AllNumbers(ledger.Plan(At(0))), (Numbers{0, 1}));
  Bring(ledger, 1, 1, 400);
  EXPECT_TRUE(ledger.Plan(At(3599)).empty());
  EXPECT_EQ(NumbersOf(ledger.Plan(At(3600)), 1), (Numbers{0}));  // nine medians: it is lost
}

TEST(OrderLedgerTest, ASampleLostOnTheWayIsOrderedAgainEvenFromTheOnlyActor) {
  OrderLedger ledger(Rules(3, 1));
  ledger.Join(1, "only", 1, At(0));
  EXPECT_EQ(AllNumbers(ledger.Plan(At(0))), (Numbers{0, 1}));
  Bring(ledger, 1, 1, 300);  // 0 never comes
  OrderLedger::TimePoint now = At(300);
  std::vector<Assignment> plan = ledger.Plan(now);
  for (int i = 0; i < 3 && plan.empty(); ++i) {
    const auto deadline = ledger.NextDeadline(now);
    ASSERT_TRUE(deadline.has_value());
    ASSERT_GT(*deadline, now) << "a deadline in the past would spin";
    now = *deadline;
    plan = ledger.Plan(now);
  }
  EXPECT_EQ(NumbersOf(plan, 1), (Numbers{0}));
  EXPECT_EQ(now, At(2700));  // nine medians
}

TEST(OrderLedgerTest, AnActorThatHangsIsTriedAgainEverLessOftenAndWithOneOrder) {
  OrderLedger ledger(Rules(40, 1));
  ledger.Join(1, "hangs", 1, At(0));
  ledger.Join(2, "works", 1, At(0));
  EXPECT_EQ(NumbersOf(ledger.Plan(At(0)), 1), (Numbers{0, 2}));
  int now = 0;
  Numbers brought_by_2{1, 3};
  std::vector<int> asked_of_1_at;
  for (std::size_t i = 0; i < brought_by_2.size() && now < 40000; ++i) {
    Bring(ledger, brought_by_2[i], 2, now += 300);
    const auto plan = ledger.Plan(At(now));
    for (const auto number : NumbersOf(plan, 2)) brought_by_2.push_back(number);
    for ([[maybe_unused]] const auto number : NumbersOf(plan, 1)) asked_of_1_at.push_back(now);
  }
  EXPECT_TRUE(ledger.IsComplete(0));
  // Orders are lost after 2700 ms (nine medians of 300), the rest after it is 1 s, 2 s, ...
  EXPECT_EQ(asked_of_1_at, (std::vector<int>{3900, 8700}));
}

TEST(OrderLedgerTest, AnActorThatWasMerelySlowWorksOnOnceItSpeaks) {
  OrderLedger ledger(Rules(40, 1));
  ledger.Join(1, "slow", 1, At(0));
  ledger.Join(2, "fast", 1, At(0));
  EXPECT_EQ(NumbersOf(ledger.Plan(At(0)), 1), (Numbers{0, 2}));
  Numbers brought_by_2{1, 3};
  int now = 0;
  for (std::size_t i = 0; now < 3300; ++i) {
    Bring(ledger, brought_by_2[i], 2, now += 300);
    const auto plan = ledger.Plan(At(now));
    for (const auto number : NumbersOf(plan, 2)) brought_by_2.push_back(number);
    EXPECT_TRUE(NumbersOf(plan, 1).empty()) << now;
  }
  // What it was given up for comes, a duplicate: it gets orders at once, two for its slot.
  EXPECT_EQ(ledger.StandingOf(0, 1), Standing::kDuplicate);
  ledger.ArriveAgain(0, 1, false, At(3310));
  EXPECT_EQ(NumbersOf(ledger.Plan(At(3310)), 1).size(), 2U);
}

TEST(OrderLedgerTest, WhatIsLateIsAskedEvenOfAnActorThatRests) {
  OrderRules rules = Rules(2, 1);
  rules.first_rest = milliseconds(50000);
  OrderLedger ledger(rules);
  ledger.Join(1, "hangs", 1, At(0));
  EXPECT_EQ(NumbersOf(ledger.Plan(At(0)), 1), (Numbers{0}));
  EXPECT_TRUE(ledger.Plan(At(17999)).empty());
  ledger.Join(2, "works", 1, At(18000));
  const auto plan = ledger.Plan(At(18000));  // lost at 1, which rests now
  EXPECT_EQ(NumbersOf(plan, 2), (Numbers{0}));
  EXPECT_TRUE(NumbersOf(plan, 1).empty());
  Bring(ledger, 0, 2, 18400);
  EXPECT_EQ(NumbersOf(ledger.Plan(At(18400)), 2), (Numbers{1}));
  EXPECT_TRUE(ledger.Plan(At(19599)).empty());
  // Three medians of 400 later it is late, and 1 has an idle slot.
  EXPECT_EQ(NumbersOf(ledger.Plan(At(19600)), 1), (Numbers{1}));
}

// Fifteen times slower all of a sudden: what is repeated stays within bounds, the estimate adapts.
TEST(OrderLedgerTest, ASuddenSlownessOfEverybodyDoesNotBuryThemUnderRepeatedOrders) {
  OrderLedger ledger(Rules(200, 1));
  ledger.Join(1, "a", 1, At(0));
  ledger.Join(2, "b", 1, At(0));
  std::map<std::uint64_t, std::deque<std::uint64_t>> queues;  // of each actor, oldest first
  std::map<std::uint64_t, int> free_at{{1, 0}, {2, 0}};
  for (int now = 0; !ledger.IsComplete(0) && now < 400'000; now += 10) {
    for (const auto& assignment : ledger.Plan(At(now))) {
      for (const auto number : assignment.numbers) queues[assignment.actor_id].push_back(number);
    }
    for (auto& [actor, queue] : queues) {
      if (queue.empty() || now < free_at[actor]) continue;
      const std::uint64_t number = queue.front();
      queue.pop_front();
      if (ledger.StandingOf(number, actor) == Standing::kWanted) {
        Bring(ledger, number, actor, now);
      } else {
        ledger.ArriveAgain(number, actor, false, At(now));
      }
      free_at[actor] = now + (now < 3000 ? 100 : 1500);
    }
  }
  EXPECT_TRUE(ledger.IsComplete(0));
  EXPECT_LT(ledger.counts().reordered, 60U);
}

TEST(OrderLedgerTest, AnActorThatIsNotTrustedYetIsAskedOnlyIfNobodyElseIsThere) {
  OrderLedger ledger(Rules(8, 1));
  ledger.Join(1, "flaps", 1, At(0), At(5000));
  EXPECT_EQ(NumbersOf(ledger.Plan(At(0)), 1), (Numbers{0, 1}));
  ledger.Lose(1, At(10));
  ledger.Join(2, "steady", 1, At(20));
  ledger.Join(1, "flaps", 1, At(20), At(5000));
  EXPECT_EQ(AllNumbers(ledger.Plan(At(20))), (Numbers{0, 1}));
  EXPECT_EQ(ledger.NextDeadline(At(4000)), At(5000));  // by when 2's orders are long late
  EXPECT_EQ(NumbersOf(ledger.Plan(At(5000)), 1), (Numbers{2, 3}));
}

TEST(OrderLedgerTest, ARejectedEpisodeIsOrderedAgainAndCountedByReasonAndActor) {
  OrderLedger ledger(Rules(2, 1));
  ledger.Join(1, "a", 1, At(0));
  ledger.Plan(At(0));
  ledger.Arrive(0, 1, At(10));
  EXPECT_FALSE(ledger.Reject(0, 1, "step 17 names head 3"));
  EXPECT_EQ(NumbersOf(ledger.Plan(At(10)), 1), (Numbers{0}));
  ledger.Arrive(0, 1, At(20));
  EXPECT_FALSE(ledger.Reject(0, 1, "step 4 names head 12"));
  EXPECT_EQ(ledger.counts().rejected, 2U);
  EXPECT_EQ(ledger.counts().rejected_by_reason.at("step # names head #"), 2U);
  EXPECT_EQ(ledger.counts().by_actor.at("a").rejected, 2U);
  EXPECT_EQ(ledger.counts().reordered, 1U);
}

TEST(OrderLedgerTest, AnActorThatKeepsSendingBadEpisodesIsNamedForRefusal) {
  OrderRules rules = Rules(4, 1);
  rules.bad_answers_allowed = 2;
  OrderLedger ledger(rules);
  ledger.Join(1, "bad", 1, At(0));
  bool refuse = false;
  int bad = 0;
  while (!refuse && bad < 100) {
    for (const auto number : AllNumbers(ledger.Plan(At(bad)))) {
      ledger.Arrive(number, 1, At(bad));
      refuse = ledger.Reject(number, 1, "nonsense");
      ++bad;
      if (refuse) break;
    }
  }
  EXPECT_EQ(bad, 3);
  ledger.Refuse(1, At(50));
  ledger.Join(1, "bad", 1, At(51));
  EXPECT_EQ(ledger.actors(), 0U);
  EXPECT_TRUE(ledger.IsRefused(1));
  ledger.Join(2, "good", 2, At(52));
  EXPECT_EQ(AllNumbers(ledger.Plan(At(52))), (Numbers{0, 1}));
}

TEST(OrderLedgerTest, AGoodEpisodeForgivesTheBadOnesBefore) {
  OrderRules rules = Rules(30, 1);
  rules.bad_answers_allowed = 1;
  OrderLedger ledger(rules);
  ledger.Join(1, "mixed", 1, At(0));
  ledger.Plan(At(0));
  for (std::uint64_t number = 0; number < 10; ++number) {
    ledger.Arrive(number, 1, At(1));
    EXPECT_FALSE(ledger.Reject(number, 1, "bad"));
    ledger.Plan(At(1));
    Bring(ledger, number, 1, 1);
    ledger.Plan(At(1));
  }
}

TEST(OrderLedgerTest, TheHostOfALostActorIsKnownWhileItMayBringANumber) {
  OrderLedger ledger(Rules(1, 3, 1));
  ledger.Join(1, "near:1", 2, At(0));
  EXPECT_EQ(NumbersOf(ledger.Plan(At(0)), 1), (Numbers{0, 1}));
  Bring(ledger, 0, 1, 10);
  ledger.Lose(1, At(20));
  ledger.Publish(1, At(30));
  EXPECT_EQ(ledger.StandingOf(1, 1), Standing::kWanted);
  EXPECT_EQ(ledger.HostOf(1), "near");
  Bring(ledger, 1, 1, 40);
  ledger.Publish(2, At(50));
  EXPECT_EQ(ledger.HostOf(1), "unknown host");
}

TEST(OrderLedgerTest, StrangersCannotBringNumbers) {
  OrderLedger ledger(Rules(4, 2));
  ledger.Join(1, "a", 1, At(0));
  ledger.Plan(At(0));
  EXPECT_EQ(ledger.StandingOf(0, 7), Standing::kNotOrdered);
  EXPECT_EQ(ledger.StandingOf(0, 1), Standing::kWanted);
  EXPECT_EQ(ledger.StandingOf(3, 1), Standing::kNotOrdered);
  EXPECT_EQ(ledger.StandingOf(7, 1), Standing::kNotOrdered);
  EXPECT_EQ(ledger.StandingOf(~std::uint64_t{0}, 1), Standing::kNotOrdered);
  EXPECT_THROW(ledger.Arrive(0, 7, At(1)), std::logic_error);
  ledger.Discard(7, "never ordered");
  EXPECT_EQ(ledger.counts().by_actor.at("strangers").rejected, 1U);
}

TEST(OrderLedgerTest, TheIdleShareIsSlotTimeWithoutAnOrder) {
  OrderLedger ledger(Rules(1, 2));
  ledger.Join(1, "a", 2, At(0));
  ledger.Plan(At(0));
  Bring(ledger, 0, 1, 300);
  // 2 slots for 400 ms: one idle throughout, the other for the last 100 ms.
  EXPECT_DOUBLE_EQ(ledger.TakeIdleShare(At(400)), 500.0 / 800.0);
  EXPECT_DOUBLE_EQ(ledger.TakeIdleShare(At(500)), 1.0);
}

TEST(OrderLedgerTest, BadRulesAreRefused) {
  OrderRules rules = Rules(0, 1);
  EXPECT_THROW(OrderLedger{rules}, std::invalid_argument);
  rules = Rules(1, 1);
  rules.first_version = 2;
  EXPECT_THROW(OrderLedger{rules}, std::invalid_argument);
}

// A world of actors that join, die, hang, lose, repeat and falsify, against the ledger.
class Simulation {
 public:
  Simulation(unsigned seed, std::uint64_t overlap) : random_(seed), rules_(Rules(12, 6, overlap)) {
    rules_.bad_answers_allowed = 50;
  }

  // @return how often each number was accepted.
  std::map<std::uint64_t, int> Run() {
    OrderLedger ledger(rules_);
    ledger_ = &ledger;
    for (int i = 0; i < 3; ++i) JoinOne();
    while (version_ < rules_.updates_total && now_ < 100'000'000) Step();
    EXPECT_EQ(version_, rules_.updates_total) << "it hangs";
    EXPECT_EQ(ledger.counts().accepted, rules_.updates_total * rules_.episodes_per_update);
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
    ledger_->Join(id, "actor", 1 + unsigned(Draw(3)), At(now_));
  }

  void SendOrders() {
    for (const Assignment& assignment : ledger_->Plan(At(now_))) {
      for (const std::uint64_t number : assignment.numbers) {
        EXPECT_EQ(assignment.weights_version, ledger_->BehaviourVersion(number));
        EXPECT_LE(assignment.weights_version, version_) << "weights that do not exist yet";
        if (Draw(10) == 0) continue;  // lost on the way
        const int duration = Draw(12) == 0 ? 5000 : 200 + Draw(200);
        busy_until_[assignment.actor_id] =
            std::max(busy_until_[assignment.actor_id], now_) + duration;
        events_.push({busy_until_[assignment.actor_id], assignment.actor_id, number});
        if (Draw(10) == 0)
          events_.push({now_ + duration + Draw(3000), assignment.actor_id, number});
      }
    }
  }

  void Step() {
    SendOrders();
    const auto deadline = ledger_->NextDeadline(At(now_));
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
    while (version_ < rules_.updates_total && ledger_->IsComplete(version_)) {
      ledger_->Publish(++version_, At(now_));
    }
  }

  void KillOne() {
    if (alive_.empty()) return;
    const auto victim = std::next(alive_.begin(), Draw(int(alive_.size())));
    ledger_->Lose(*victim, At(now_));
    alive_.erase(victim);  // what it sent before may still arrive
  }

  void Receive(const Event& event) {
    switch (ledger_->StandingOf(event.number, event.actor)) {
      case Standing::kWanted:
        ledger_->Arrive(event.number, event.actor, At(now_));
        if (Draw(8) == 0) {
          if (ledger_->Reject(event.number, event.actor, "bad"))
            ledger_->Refuse(event.actor, At(now_));
        } else {
          ledger_->Accept(event.number, event.actor);
          ++accepted_[event.number];
        }
        break;
      case Standing::kDuplicate:
        ledger_->ArriveAgain(event.number, event.actor, false, At(now_));
        break;
      case Standing::kNotOrdered:
        ADD_FAILURE() << "ordered, and now unknown: " << event.number;
    }
  }

  std::mt19937 random_;
  OrderRules rules_;
  OrderLedger* ledger_ = nullptr;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  std::map<std::uint64_t, int> accepted_;
  std::map<std::uint64_t, int> busy_until_;
  std::set<std::uint64_t> alive_;
  std::uint64_t next_actor_ = 1;
  std::uint64_t version_ = 0;
  int now_ = 0;
};

TEST(OrderLedgerTest, WhateverActorsDoEachNumberIsAcceptedExactlyOnceAndTheRunEnds) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const auto accepted = Simulation(seed, seed % 2).Run();
    ASSERT_EQ(accepted.size(), 72U) << "seed " << seed;
    for (const auto& [number, times] : accepted) {
      ASSERT_EQ(times, 1) << "number " << number << ", seed " << seed;
    }
  }
}

}  // namespace
}  // namespace metronome
