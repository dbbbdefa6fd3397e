#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/messages/episode.h"
#include "common/messages/messages.h"
#include "common/policy/train_state.h"
#include "learner/learning/update_report.h"

namespace metronome {

/// A loss, gradient or parameter of an update is not finite, or actions of the new policy may not
/// be.
class NonFiniteUpdate : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What the coordinator needs of the mathematics: the trainer behind a seam, so that coordination
/// is tested without it. All but Update are quick; no two calls at a time touch the state.
class Learning {
 public:
  virtual ~Learning() = default;
  /// Not while Update runs.
  [[nodiscard]] virtual const TrainState& state() const = 0;
  /// Learns from the E episodes of batch state().version, in number order. Takes seconds; called on
  /// another thread than the rest. @throws NonFiniteUpdate, the state unchanged.
  virtual UpdateReport Update(const std::vector<Episode>& batch) = 0;
  /// What actors act with at state.version, and at the version before (not at version 0).
  [[nodiscard]] virtual PolicySnapshot Snapshot(const TrainState& state) const = 0;
  [[nodiscard]] virtual PolicySnapshot PreviousSnapshot(const TrainState& state) const = 0;
  /// Why the episode cannot be right under this snapshot, or std::nullopt. Also while Update runs;
  /// one call at a time.
  [[nodiscard]] virtual std::optional<std::string> Check(const Episode& episode,
                                                         const PolicySnapshot& snapshot) const = 0;
};

}  // namespace metronome
