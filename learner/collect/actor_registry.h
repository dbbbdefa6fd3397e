#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/messages/bus.h"
#include "common/messages/messages.h"
#include "learner/collect/admission.h"
#include "learner/collect/assignments/roster.h"
#include "learner/collect/episode_counts.h"
#include "learner/collect/trust/trust.h"

namespace metronome::collect {

/// The actors of a run: who is admitted, what each is called and last said of itself, and how those
/// who are turned away are told. Not thread-safe. Bus errors pass through.
class ActorRegistry {
 public:
  using TimePoint = Clock::time_point;

  /// @param description  what the learner publishes. @param digest  the checkpoint's canonical
  /// digest, empty at first. @param bus, trust  must outlive the registry.
  ActorRegistry(const RunDescription& description, const std::string& digest, LearnerBus* bus,
                trust::Trust* trust);

  enum class Verdict { kAdmitted, kNotYet, kRefused };
  /// Judges the actor anew and, if it is refused, tells it so.
  Verdict Hear(const ActorStatus& status, TimePoint now);
  /// Nothing is heard of it from here on; it is told why.
  void Refuse(std::uint64_t actor_id, const std::string& name, const std::string& reason);
  /// @return whether it was admitted.
  bool Lose(std::uint64_t actor_id);

  /// "host:process", both in its own words; `otherwise` of one that is not there.
  [[nodiscard]] std::string NameOf(std::uint64_t actor_id, const std::string& otherwise) const;
  /// Of all that are there.
  [[nodiscard]] std::set<std::string> Names() const;
  /// The actors of a host, as the middleware knows it: their names by id.
  [[nodiscard]] std::map<std::uint64_t, std::string> NamesOn(const std::string& host) const;
  /// Of the run's canonical episode.
  [[nodiscard]] const std::string& digest() const { return admission_.digest(); }
  /// Those of `roster`, for people who watch.
  [[nodiscard]] std::vector<ActorReport> Report(const assignments::Roster& roster,
                                                const EpisodeCounts& counts, TimePoint now) const;

 private:
  /// An admitted actor's last word of itself.
  struct Actor {
    std::string name;
    std::string host;
    TimePoint heard;
    std::uint64_t episodes_done = 0;
    double steps_per_second = 0;
  };
  void Welcome(const ActorStatus& status, const trust::Trust::Probation& probation,
               TimePoint now) const;
  void SendRefusal(std::uint64_t actor_id, const std::string& reason);

  std::uint64_t incarnation_;
  Admission admission_;
  LearnerBus& bus_;
  trust::Trust& trust_;
  std::map<std::uint64_t, Actor> actors_;  // that were admitted and are there
};

}  // namespace metronome::collect
