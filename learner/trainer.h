#pragma once

#include <memory>
#include <stdexcept>
#include <vector>

#include "common/config.pb.h"
#include "common/episode.h"
#include "common/snapshot.h"
#include "common/train_state.h"
#include "learner/update_report.h"

namespace metronome {

/// A loss, gradient or parameter of an update is not finite, or actions of the new policy may not
/// be.
class NonFiniteUpdate : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Multi-head PPO: next state = f(state, batch), bit for bit, whatever the number of threads.
/// Knows nothing of DDS, files or MuJoCo. Not thread-safe: one call at a time.
class Trainer {
 public:
  /// @param config   resolved (common/config.h).
  /// @param threads  worker threads, at least 1; they never change the result.
  /// @throws std::invalid_argument if `state` does not fit the configuration's shape.
  Trainer(const RunConfig& config, TrainState state, int threads);
  ~Trainer();

  /// Version 0: orthogonal initialisation from the seed, empty statistics.
  static TrainState InitialState(const RunConfig& config);

  [[nodiscard]] const TrainState& state() const;

  /// Learns from the batch of version state().version: its E episodes in number order.
  /// @throws NonFiniteUpdate and leaves the state as it was.
  UpdateReport Update(const std::vector<Episode>& batch);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace metronome
