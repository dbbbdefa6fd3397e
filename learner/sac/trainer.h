#pragma once

#include <memory>
#include <vector>

#include "common/messages/episode.h"
#include "common/schema/config.pb.h"
#include "learner/sac/sac_report.h"
#include "learner/sac/sac_state.h"

namespace metronome::sac {

/// Multi-head SAC: next state = f(state, replay, batch), bit for bit, whatever the number of
/// threads. Knows nothing of DDS, files or MuJoCo. Not thread-safe: one call at a time.
class Trainer {
 public:
  /// @param config   resolved (common/config/config.h).
  /// @param state    as DecodeSacState gives it.
  /// @param replay   the episodes that the replay had then, in number order.
  /// @param threads  worker threads, at least 1; they never change the result.
  Trainer(const RunConfig& config, SacState state, const std::vector<Episode>& replay, int threads);
  ~Trainer();

  [[nodiscard]] const SacState& state() const;

  /// Takes the batch of version state().version, its E episodes in number order, into the replay,
  /// and makes the gradient steps that have become due.
  /// @throws NonFiniteUpdate (learner/algorithm/algorithm.h): the state is as it was.
  SacReport Update(const std::vector<Episode>& batch);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace metronome::sac
