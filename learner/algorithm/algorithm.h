#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/checkpoint/train_state.h"
#include "common/messages/episode.h"
#include "common/messages/messages.h"
#include "learner/algorithm/metric.h"
#include "learner/algorithm/update_report.h"

namespace metronome::algorithm {

/// A loss, gradient or parameter of an update is not finite, or actions of the new policy may not
/// be.
class NonFiniteUpdate : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An algorithm: next state = f(state, batch of numbered episodes), the same bits on any
/// machine's threads. All that coordination, checkpoints and logs know of the mathematics. All but
/// Update are quick; no two calls at a time touch the state.
class Algorithm {
 public:
  virtual ~Algorithm() = default;

  /// Not while Update runs.
  [[nodiscard]] virtual const checkpoint::RunCounters& counters() const = 0;
  /// Learns from the E episodes, of any length each, of batch counters().version, in number order.
  /// Takes seconds; called on another thread than the rest.
  /// @throws NonFiniteUpdate, the state unchanged.
  virtual UpdateReport Update(const std::vector<Episode>& batch) = 0;
  /// For a checkpoint; without the canonical digest, which is not the algorithm's. Not while Update
  /// runs.
  [[nodiscard]] virtual checkpoint::TrainState State() const = 0;

  /// The policy for actors at this version, and at the version before (not at version 0; of use
  /// with collection.overlap 1 alone). Not while Update runs.
  [[nodiscard]] virtual PolicySnapshot Snapshot() const = 0;
  [[nodiscard]] virtual PolicySnapshot PreviousSnapshot() const = 0;
  /// Why the episode cannot be right under this snapshot, or std::nullopt. Also while Update runs;
  /// one call at a time.
  [[nodiscard]] virtual std::optional<std::string> Check(const Episode& episode,
                                                         const PolicySnapshot& snapshot) const = 0;

  /// The metrics of every UpdateReport of this run, in their order, with values of no meaning:
  /// what columns progress.csv has.
  [[nodiscard]] virtual std::vector<Metric> Metrics() const = 0;
};

}  // namespace metronome::algorithm
