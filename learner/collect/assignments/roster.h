#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace metronome::collect::assignments {

/// The actors that are there, their envs and the assignments that each has. Pure bookkeeping on
/// given time points; not thread-safe.
class Roster {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  struct Assignment {
    std::uint64_t number = 0;
    TimePoint since;  // sent, or later: when an env became free for it
  };
  struct Actor {
    std::string host;
    std::uint32_t envs = 1;
    // The first `envs` are being played, the others wait. May hold numbers that are learnt from:
    // what was late and came from elsewhere keeps its env busy none the less.
    std::vector<Assignment> assignments;
    std::vector<Assignment> given_up;  // the last few; they may come yet
  };
  using Actors = std::map<std::uint64_t, Actor>;  // by id

  /// The actor is there (again) with so many envs; at least 1.
  void Join(std::uint64_t actor_id, const std::string& host, std::uint32_t envs);
  /// @return the numbers that it still had.
  std::vector<std::uint64_t> Leave(std::uint64_t actor_id);

  void Give(std::uint64_t actor_id, std::uint64_t number, TimePoint now);
  /// The actor has brought it: the assignment that waited longest begins.
  /// @return how long it took; std::nullopt if it was not assigned to this actor, or long ago.
  std::optional<std::chrono::nanoseconds> Release(std::uint64_t actor_id, std::uint64_t number,
                                                  TimePoint now);
  /// Takes away the assignments that `is_lost`. @return their numbers, by actor.
  std::map<std::uint64_t, std::vector<std::uint64_t>> GiveUp(
      const std::function<bool(const Assignment&)>& is_lost);

  [[nodiscard]] const Actors& actors() const { return actors_; }
  [[nodiscard]] std::uint64_t envs() const { return envs_; }
  /// Envs without an assignment.
  [[nodiscard]] std::uint64_t idle() const;
  /// The actor with the least assignments an env, of those that have less than
  /// `assignments_per_env` and less than `room` says that this one may; std::nullopt if there is
  /// none. The lower id of two.
  [[nodiscard]] std::optional<std::uint64_t> LeastLoaded(
      std::uint32_t assignments_per_env,
      const std::function<std::size_t(const Actors::value_type&)>& room) const;

 private:
  Actors actors_;
  std::uint64_t envs_ = 0;  // of them all
};

}  // namespace metronome::collect::assignments
