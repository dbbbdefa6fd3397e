#pragma once

#include <cstdint>
#include <vector>

#include "actor/environment/registry.h"
#include "common/messages/episode.h"
#include "common/messages/messages.h"
#include "common/schema/config.pb.h"

namespace metronome::bench {

/// Those of metronome-actor.
const environment::EnvironmentRegistry& Registry();

/// Episodes that a learner accepts, without physics: the observations, rewards and flags of a few
/// episodes that were really played, in turn, under the actions and log-probabilities that the
/// policy gives for the number that is asked for. Immutable once made, hence thread-safe; shared
/// by processes that fork afterwards.
class EpisodeBank {
 public:
  /// Plays `recordings` episodes under version 0 (untrained) and works out the decisions of the
  /// numbers 0..prepared-1 under it, on all cores. Needs the scene files.
  /// @param config  resolved, with a task.
  EpisodeBank(RunConfig config, std::uint64_t recordings, std::uint64_t prepared);

  /// Episode `number` under `snapshot`: a copy for what is prepared, else worked out (T decisions
  /// of the policy, milliseconds).
  [[nodiscard]] Episode Make(std::uint64_t number, const PolicySnapshot& snapshot) const;

  [[nodiscard]] std::uint64_t prepared() const { return prepared_.size(); }
  [[nodiscard]] const RunConfig& config() const { return config_; }
  [[nodiscard]] const PolicySnapshot& untrained() const { return untrained_; }

 private:
  /// The part of an episode that depends on its number.
  struct Decisions {
    std::vector<float> action;        // [T, A]
    std::vector<float> log_prob;      // [T], nats
    std::vector<std::uint16_t> head;  // [T]
  };

  [[nodiscard]] const Episode& RecordingOf(std::uint64_t number) const;
  [[nodiscard]] Decisions Decide(std::uint64_t number, const PolicySnapshot& snapshot) const;
  void Prepare(std::uint64_t count);

  RunConfig config_;
  PolicySnapshot untrained_;
  std::vector<Episode> recordings_;
  std::vector<Decisions> prepared_;  // by number, under version 0
};

}  // namespace metronome::bench
