#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "common/messages/bus.h"
#include "common/messages/messages.h"
#include "learner/collect/admission.h"
#include "learner/collect/audit.h"
#include "learner/collect/batch_store.h"
#include "learner/collect/excluded_hosts.h"
#include "learner/collect/flap_watch.h"
#include "learner/collect/log_limit.h"
#include "learner/collect/order_ledger.h"
#include "learner/learning/learning.h"

namespace metronome {

/// Gathers the batches of a run: admits actors, orders episodes from them, checks what they bring.
/// Not thread-safe; lives in the coordinator's thread. Bus errors pass through.
class Collector {
 public:
  using TimePoint = Clock::time_point;

  /// @param description  what the learner publishes.
  /// @param digest       the checkpoint's canonical digest, empty at first.
  /// @param excluded     by earlier starts of the learner.
  Collector(LearnerBus& bus, const Learning& learning, const RunDescription& description,
            const OrderRules& rules, const std::string& digest, ExcludedHosts excluded);

  void OnStatus(const ActorStatus& status, TimePoint now);
  void OnLost(std::uint64_t actor_id, TimePoint now);
  void OnEpisode(EpisodeMessage message, TimePoint now);
  void OnBadSample(const BadSample& sample, TimePoint now);

  /// Weights that episodes may have been played under; the latest two versions are kept.
  void AddSnapshot(PolicySnapshot snapshot);
  /// Batch version - 1 has been learnt from.
  void CountEntered(const std::vector<Episode>& batch);
  void Publish(std::uint64_t version, TimePoint now) { ledger_.Publish(version, now); }

  /// Settles and sends what is due. @return when to call again even if nothing happens.
  std::optional<TimePoint> SendOrders(TimePoint now);

  [[nodiscard]] bool IsComplete(std::uint64_t batch) const { return ledger_.IsComplete(batch); }
  BatchStore::Batch Take(std::uint64_t batch) { return batches_.Take(batch); }

  [[nodiscard]] const std::string& digest() const { return admission_.digest(); }
  [[nodiscard]] std::uint64_t actors() const { return ledger_.actors(); }
  [[nodiscard]] std::uint64_t slots() const { return ledger_.slots(); }
  [[nodiscard]] const LedgerCounts& counts() const { return ledger_.counts(); }
  /// Samples for another start of the learner: dropped, answered by the new orders.
  [[nodiscard]] std::uint64_t stale() const { return stale_; }
  [[nodiscard]] std::uint64_t AcceptedOf(std::uint64_t batch) const {
    return ledger_.AcceptedOf(batch);
  }
  /// The actors that are there, for people who watch.
  [[nodiscard]] std::vector<ActorReport> ReportActors(TimePoint now) const;
  [[nodiscard]] const ExcludedHosts& excluded() const { return excluded_; }
  /// What the audit found, for people; empty if nothing is audited.
  [[nodiscard]] std::string AuditText() const;
  [[nodiscard]] BatchStore::Accounting Account() const { return batches_.Account(); }
  double TakeIdleShare(TimePoint now) { return ledger_.TakeIdleShare(now); }

 private:
  /// What an admitted actor last said of itself.
  struct LastWords {
    TimePoint heard;
    std::uint64_t episodes_done = 0;
    double steps_per_second = 0;
  };
  void RefuseActor(std::uint64_t actor_id, const std::string& name, const std::string& reason,
                   TimePoint now);
  void SendRefusal(std::uint64_t actor_id, const std::string& reason);
  [[nodiscard]] bool IsBarred(std::uint64_t actor_id) const;
  void Judge(Episode episode, std::uint64_t actor_id, TimePoint now);
  void Hear(Episode episode, std::uint64_t actor_id, TimePoint now);
  void SendPlan(TimePoint now);
  std::optional<TimePoint> SettleLonely(TimePoint now);
  void ExcludeHost(const std::string& host, std::uint64_t number, TimePoint now);
  void OnDuplicate(const Episode& episode, std::uint64_t actor_id, TimePoint now);
  void Discard(std::uint64_t actor_id, const std::string& reason, TimePoint now);
  void Complain(const std::string& text, TimePoint now);
  void Welcome(const ActorStatus& status, const std::string& name, TimePoint trusted_from,
               TimePoint now) const;
  void WarnOfManySlots();
  [[nodiscard]] std::string NameOf(std::uint64_t actor_id) const;

  LearnerBus& bus_;
  const Learning& learning_;
  std::uint64_t incarnation_;
  std::uint64_t episodes_per_update_;
  Admission admission_;
  FlapWatch flaps_;
  OrderLedger ledger_;
  Audit audit_;
  BatchStore batches_;
  std::map<std::uint64_t, PolicySnapshot> snapshots_;  // by version
  std::map<std::uint64_t, std::string> names_;         // of the actors that were admitted
  std::map<std::uint64_t, LastWords> last_words_;      // of the same
  std::map<std::uint64_t, std::string> refusals_;      // actor -> reason
  ExcludedHosts excluded_;
  LogLimit complaints_;
  std::uint64_t stale_ = 0;
  std::optional<TimePoint> lonely_since_;  // nobody is there to play audited episodes again
  std::uint64_t slots_warned_of_ = 0;
};

}  // namespace metronome
