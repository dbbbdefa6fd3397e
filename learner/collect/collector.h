#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/messages/bus.h"
#include "common/messages/messages.h"
#include "learner/algorithm/algorithm.h"
#include "learner/collect/actor_registry.h"
#include "learner/collect/assignments/assignment_plan.h"
#include "learner/collect/assignments/number_book.h"
#include "learner/collect/audit_desk.h"
#include "learner/collect/batch_store.h"
#include "learner/collect/episode_counts.h"
#include "learner/collect/log_limit.h"
#include "learner/collect/trust/trust.h"

namespace metronome::collect {

/// The rules of handing out episodes and of trust.
struct CollectRules {
  assignments::AssignmentRules assignments;
  trust::TrustRules trust;
  trust::AuditRules audit;
};

/// Gathers the batches of a run: sends assignments, and takes each episode that comes the one way
/// from the wire to its batch (OnEpisode). Not thread-safe; lives in the coordinator's thread. Bus
/// errors pass through.
class Collector {
 public:
  using TimePoint = Clock::time_point;

  /// @param description  what the learner publishes.
  /// @param digest       the checkpoint's canonical digest, empty at first.
  /// @param excluded     by earlier starts of the learner.
  Collector(LearnerBus& bus, const algorithm::Algorithm& algorithm,
            const RunDescription& description, const CollectRules& rules, const std::string& digest,
            trust::ExcludedHosts excluded);

  void OnStatus(const ActorStatus& status, TimePoint now);
  void OnLost(std::uint64_t actor_id, TimePoint now);
  void OnEpisode(EpisodeMessage message, TimePoint now);
  void OnBadSample(const BadSample& sample, TimePoint now);

  /// Settles and sends what is due. @return when to call again even if nothing happens.
  std::optional<TimePoint> SendAssignments(TimePoint now);

  /// Episodes of the batch that are accepted so far; E: it is complete.
  [[nodiscard]] std::uint64_t AcceptedOf(std::uint64_t batch) const {
    return book_.AcceptedOf(batch);
  }
  struct Collected {
    BatchStore::Batch batch;
    double idle_share = 0;  // of the actors' envs while it was collected
  };
  /// A complete batch, to be learnt from.
  Collected Take(std::uint64_t batch, TimePoint now);
  /// The batch has been learnt from, which made this version.
  void Publish(std::uint64_t version, const std::vector<Episode>& batch, TimePoint now);
  /// Weights that episodes may have been played under; the latest two versions are kept.
  void AddSnapshot(PolicySnapshot snapshot);

  /// For people who watch.
  [[nodiscard]] const EpisodeCounts& counts() const { return counts_; }
  [[nodiscard]] const assignments::Roster& roster() const { return plan_.roster(); }
  [[nodiscard]] std::vector<ActorReport> ReportActors(TimePoint now) const {
    return registry_.Report(roster(), counts_, now);
  }
  /// The audit's findings; empty if nothing is audited.
  [[nodiscard]] std::string AuditText() const { return desk_.Text(excluded()); }
  /// @param updates  made, all starts together.
  [[nodiscard]] BatchStore::Accounting Account(std::uint64_t updates) const {
    return batches_.Account(updates);
  }
  /// For whoever keeps them.
  [[nodiscard]] const std::string& digest() const { return registry_.digest(); }
  [[nodiscard]] const trust::ExcludedHosts& excluded() const { return trust_.excluded(); }

 private:
  void Drop(std::uint64_t actor_id, const std::string& reason, TimePoint now);
  void Compare(const Episode& episode, std::uint64_t actor_id, TimePoint now);
  void Reject(std::uint64_t number, std::uint64_t actor_id, const std::string& reason,
              TimePoint now);
  void Follow(AuditDesk::Ruling ruling, std::uint64_t number, std::uint64_t actor_id,
              TimePoint now);
  void Enter(Settled settled);
  void Refuse(std::uint64_t actor_id, const std::string& name, const std::string& reason,
              TimePoint now);
  void Exclude(const std::string& host, std::uint64_t number, TimePoint now);
  void SendPlan(TimePoint now);
  void Complain(const std::string& text, TimePoint now);
  void WarnOfManyEnvs();
  [[nodiscard]] std::string Called(std::uint64_t actor_id) const;

  LearnerBus& bus_;
  const algorithm::Algorithm& algorithm_;
  std::uint64_t incarnation_;
  assignments::AssignmentRules rules_;
  trust::Trust trust_;
  ActorRegistry registry_;
  assignments::NumberBook book_;
  assignments::AssignmentPlan plan_;
  BatchStore batches_;
  AuditDesk desk_;
  EpisodeCounts counts_;
  std::map<std::uint64_t, PolicySnapshot> snapshots_;  // by version
  LogLimit complaints_;
  bool has_warned_of_envs_ = false;
};

}  // namespace metronome::collect
