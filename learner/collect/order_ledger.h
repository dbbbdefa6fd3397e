#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "learner/collect/audit.h"
#include "learner/collect/duration_median.h"
#include "learner/collect/ledger_counts.h"

namespace metronome {

/// What may be ordered, and when an order counts as late.
struct OrderRules {
  std::uint64_t episodes_per_update = 16;  // E
  std::uint64_t overlap = 0;               // batch v is played under weights max(0, v - overlap)
  std::uint64_t updates_total = 1;         // batches 0 .. updates_total - 1
  std::uint64_t first_version = 0;         // updates made before this process
  std::uint32_t orders_per_slot = 2;       // so that no slot waits for a round trip
  double late_factor = 3;                  // of the median duration: another idle slot is asked too
  double lost_factor = 9;                  // of the median: given up; doubled for each further try
  std::chrono::milliseconds least_late{250};       // shorter lateness is noise
  std::chrono::milliseconds first_estimate{2000};  // of the median, before any was measured
  // An actor that gave up an order is on trial after this, doubled with each further one.
  std::chrono::milliseconds first_rest{1000};
  std::chrono::milliseconds longest_rest{60'000};
  std::uint32_t bad_answers_allowed = 10;  // in a row, by one actor
  AuditRules audit;
};

/// Numbers to be sent to one actor, all to be played under one weights version.
struct Assignment {
  std::uint64_t actor_id = 0;
  std::uint64_t weights_version = 0;
  std::vector<std::uint64_t> numbers;  // in the order to play them
  bool operator==(const Assignment&) const = default;
};

/// Who plays which episode: every number of the run is handed out, taken back from the lost and the
/// late, and accepted exactly once, lowest numbers first. Pure bookkeeping: no clock of its own
/// (time points are given and must not decrease), no messages, no episodes. Not thread-safe.
///
/// A number is open (to be handed out), out (with one actor or, when late, several), arrived (being
/// checked) or accepted; it leaves the ledger once its batch is learnt from.
class OrderLedger {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// Who may bring a number.
  enum class Standing {
    kWanted,      // it was ordered from this actor and is missing
    kDuplicate,   // it has been accepted (or learnt from) before
    kNotOrdered,  // never ordered from this actor, or not orderable yet
  };

  /// @throws std::invalid_argument if a count is 0 or first_version exceeds updates_total.
  explicit OrderLedger(const OrderRules& rules);

  /// The actor is there (again) with so many slots; at least 1. Refused actors stay refused.
  /// @param name          "host:process". @param trusted_from  before that it is asked only if no
  /// trusted one is there.
  void Join(std::uint64_t actor_id, const std::string& name, std::uint32_t slots, TimePoint now,
            TimePoint trusted_from = {});
  /// What it has not brought is open again at once. @return how many orders that were.
  std::size_t Lose(std::uint64_t actor_id, TimePoint now);
  /// Nothing is ordered from this actor any more; the caller drops what it still brings.
  void Refuse(std::uint64_t actor_id, TimePoint now);
  [[nodiscard]] bool IsRefused(std::uint64_t actor_id) const { return refused_.contains(actor_id); }

  /// Batch version - 1 has been learnt from: its numbers leave the ledger, batch version + overlap
  /// may be ordered. @throws std::logic_error unless that batch was complete and version is next.
  void Publish(std::uint64_t version, TimePoint now);

  [[nodiscard]] Standing StandingOf(std::uint64_t number, std::uint64_t actor_id) const;
  /// Weights that episode `number` is played under.
  [[nodiscard]] std::uint64_t BehaviourVersion(std::uint64_t number) const;

  /// A wanted number is here and being checked: its slot is free, nobody else is asked for it.
  void Arrive(std::uint64_t number, std::uint64_t actor_id, TimePoint now);
  /// The check's verdicts, after Arrive.
  void Accept(std::uint64_t number, std::uint64_t actor_id);
  /// Opens the number again. @return true if this actor brought too many bad ones in a row: refuse
  /// it.
  bool Reject(std::uint64_t number, std::uint64_t actor_id, const std::string& reason);
  /// In place of a verdict, after Arrive: somebody else is to play the number too, on another host
  /// if there is one. @param disputed  hosts differ: only a host that was not heard is asked.
  void AskAnother(std::uint64_t number, std::uint64_t actor_id, bool disputed);
  /// An actor is there that AskAnother may ask and that answers its orders.
  [[nodiscard]] bool HasOther(std::uint64_t number) const;
  /// As Accept, of a number that another was asked for. @param hosts  that brought what stands.
  void AcceptHeard(std::uint64_t number, std::uint64_t actor_id, std::vector<std::string> hosts);
  /// Accepted numbers that no other host vouches for.
  [[nodiscard]] std::vector<std::uint64_t> OnTheWordOf(const std::string& host) const;
  /// The number is open as if nobody had brought it.
  void Reopen(std::uint64_t number);

  /// A sample that answers no order: counted, nothing else changes.
  void Discard(std::uint64_t actor_id, const std::string& reason);
  /// A number that has been accepted before came again; if it was ordered from this actor, its slot
  /// is free. @param differs  from the accepted one.
  void ArriveAgain(std::uint64_t number, std::uint64_t actor_id, bool differs, TimePoint now);

  /// Hands out what is due: open numbers to the least loaded slots, late ones to idle slots.
  /// The caller sends them; if that fails, it calls Lose.
  std::vector<Assignment> Plan(TimePoint now);
  /// When Plan has work to do even if nothing happens; std::nullopt: never.
  [[nodiscard]] std::optional<TimePoint> NextDeadline(TimePoint now) const;

  /// All E episodes of the batch are accepted.
  [[nodiscard]] bool IsComplete(std::uint64_t batch) const;

  /// Episodes of the batch that are accepted so far.
  [[nodiscard]] std::uint64_t AcceptedOf(std::uint64_t batch) const;

  /// One actor's orders, for people who watch.
  struct ActorOrders {
    std::uint64_t actor_id = 0;
    std::string name;
    std::uint32_t slots = 0;
    std::uint64_t orders = 0;         // outstanding
    std::optional<TimePoint> oldest;  // since when it could have played the oldest of them
    bool trusted = true;
    bool silent = false;  // gave up an order and has brought nothing since
  };
  [[nodiscard]] std::vector<ActorOrders> OrdersByActor(TimePoint now) const;

  /// Of an actor that is there, or was asked for a number that has not been learnt from.
  [[nodiscard]] const std::string& HostOf(std::uint64_t actor_id) const;
  [[nodiscard]] std::size_t actors() const { return actors_.size(); }
  [[nodiscard]] std::uint64_t slots() const;
  [[nodiscard]] const LedgerCounts& counts() const { return counts_; }
  /// Share of slot time without an order since the last call, in [0, 1]; 0 without slots.
  double TakeIdleShare(TimePoint now);

 private:
  struct Number {
    enum class State { kOpen, kOut, kArrived, kAccepted };
    State state = State::kOpen;
    std::vector<std::uint64_t> holders;  // actors that play it, latest last
    std::vector<std::uint64_t> asked;    // every actor that was ever asked for it
    std::uint32_t tries = 0;             // times that it was handed out
    std::vector<std::uint64_t> heard;    // actors that brought it: never asked again
    std::vector<std::string> hosts;      // of those; once accepted: that brought what stands
    bool disputed = false;               // these hosts differ
  };
  struct Outstanding {
    std::uint64_t number = 0;
    TimePoint since;  // sent, or later: when a slot became free for it
  };
  struct Actor {
    std::string name;
    std::uint32_t slots = 1;
    // The first `slots` are being played, the others wait. May hold numbers that left the ledger:
    // what was late and came from elsewhere keeps its slot busy none the less.
    std::vector<Outstanding> out;
    std::vector<Outstanding> given_up;  // the last few orders; they may come yet
    std::uint32_t bad_in_a_row = 0;
    std::uint32_t silences = 0;  // times that it gave up orders since it last brought something
    TimePoint rests_until;       // because of them: then one order is its trial
    TimePoint trusted_from;      // see Join
    [[nodiscard]] bool IsReliable(TimePoint now) const {
      return rests_until <= now && trusted_from <= now;
    }
  };
  using ActorMap = std::map<std::uint64_t, Actor>;

  void OpenBatches();
  void ForgetHosts();
  void ForgetCountsOfLost();
  void Hear(Number& number, std::uint64_t actor_id);
  void TakeBack(std::uint64_t number, std::uint64_t actor_id);
  std::size_t Drop(std::uint64_t actor_id);
  void Release(ActorMap::value_type& actor, std::uint64_t number, TimePoint now);
  void HandOut(std::uint64_t number, ActorMap::value_type& actor, TimePoint now,
               std::vector<Assignment>& plan);
  [[nodiscard]] bool MayPlay(const Number& number, const ActorMap::value_type& actor) const;
  [[nodiscard]] bool OtherHostIsThere(const Number& number) const;
  ActorMap::value_type* LeastLoaded(
      std::uint32_t orders_per_slot, const Number& number,
      const std::function<bool(const ActorMap::value_type&)>& may_be_asked);
  ActorMap::value_type* Another(std::uint32_t orders_per_slot, const Number& number);
  void GiveUpLost(TimePoint now);
  [[nodiscard]] std::chrono::nanoseconds LostAfter(const Outstanding& out) const;
  void PlanOpen(TimePoint now, std::vector<Assignment>& plan);
  void PlanLate(TimePoint now, std::vector<Assignment>& plan);
  [[nodiscard]] std::chrono::nanoseconds Scaled(double factor) const;
  void CountIdle(TimePoint now);

  OrderRules rules_;
  std::uint64_t version_;     // latest weights
  std::uint64_t next_batch_;  // first batch that is not in numbers_ yet
  std::map<std::uint64_t, Number>
      numbers_;  // of the batches that may be ordered or are in the making
  std::set<std::uint64_t> open_;
  std::map<std::uint64_t, std::uint64_t> accepted_of_batch_;
  ActorMap actors_;
  std::map<std::uint64_t, std::string> host_of_;  // actors, lost ones among them: see HostOf
  std::set<std::uint64_t> refused_;
  LedgerCounts counts_;
  DurationMedian durations_;
  std::optional<TimePoint> counted_until_;
  double slot_seconds_ = 0;
  double idle_seconds_ = 0;
};

}  // namespace metronome
