#pragma once

#include <memory>
#include <vector>

#include "common/messages/episode.h"
#include "common/schema/config.pb.h"
#include "learner/ppo/ppo_report.h"
#include "learner/ppo/ppo_state.h"

namespace metronome::ppo {

/// Multi-head PPO: next state = f(state, batch), bit for bit, whatever the number of threads.
/// Knows nothing of DDS, files or MuJoCo. Not thread-safe: one call at a time.
class Trainer {
 public:
  /// @param config   resolved (common/config/config.h).
  /// @param threads  worker threads, at least 1; they never change the result.
  /// @throws std::invalid_argument if `state` does not fit the configuration's shape.
  Trainer(const RunConfig& config, PpoState state, int threads);
  ~Trainer();

  /// Version 0: orthogonal initialisation from the seed, empty statistics.
  static PpoState InitialState(const RunConfig& config);

  [[nodiscard]] const PpoState& state() const;

  /// Learns from the batch of version state().version: its E episodes in number order.
  /// @throws NonFiniteUpdate (learner/algorithm/algorithm.h) and leaves the state as it was.
  PpoReport Update(const std::vector<Episode>& batch);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace metronome::ppo
