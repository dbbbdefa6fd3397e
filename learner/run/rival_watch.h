#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "common/messages/messages.h"

namespace metronome::run {

/// How long a starting learner looks around, and how long a dead one may still be seen.
struct RivalTimes {
  std::chrono::milliseconds discovery{300};
  std::chrono::milliseconds lease{3000};
};

/// Whether this learner may serve its run, given the other learners of the same run that it sees.
/// Pure logic on given time points; not thread-safe.
///
/// Starting: nobody seen within the discovery time, or only starting ones of higher id - go on.
/// Whoever else is seen has one lease to vanish (our own ghost after kill -9 does); one that stays
/// and serves, or starts with a lower id, wins.
/// Serving: starting ones refuse themselves. Against another serving one the younger yields, then
/// the higher id: who began to serve less than a lease ago waits 1 lease (lower id seen) or 2
/// (higher id seen), an established one 3 (lower id seen) or for ever (higher id seen), then stops.
class RivalWatch {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  RivalWatch(std::uint64_t own_id, const RivalTimes& times, TimePoint started);

  void See(const RunDescription& rival, TimePoint now);
  void Lose(std::uint64_t learner_id);
  /// From now on this learner serves.
  void Serve(TimePoint now);

  /// Starting: nothing stands in the way any more.
  [[nodiscard]] bool MayServe(TimePoint now) const;
  /// Why this learner has to stop, or std::nullopt.
  [[nodiscard]] std::optional<std::string> MustStop(TimePoint now) const;
  /// When an answer above may change by time alone; std::nullopt: never.
  [[nodiscard]] std::optional<TimePoint> NextDeadline(TimePoint now) const;

 private:
  struct Rival {
    RunDescription description;
    TimePoint seen;  // first
  };
  /// When `rival` makes us stop; std::nullopt: never.
  [[nodiscard]] std::optional<TimePoint> YieldsAt(const Rival& rival) const;

  std::uint64_t own_id_;
  RivalTimes times_;
  TimePoint started_;
  std::optional<TimePoint> serving_since_;
  std::map<std::uint64_t, Rival> rivals_;
};

}  // namespace metronome::run
