#include "common/snapshot.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "common/episode.h"
#include "common/network.h"

namespace metronome {
namespace {

PolicySnapshot MakeSnapshot(std::uint64_t version, const float* actor, std::size_t actor_size,
                            const RunningStatistics& observation) {
  PolicySnapshot snapshot;
  snapshot.version = version;
  snapshot.parameters.assign(actor, actor + actor_size);
  snapshot.observation_mean.assign(kObservationSize, 0.0F);
  snapshot.observation_inv_std.assign(kObservationSize, 1.0F);
  if (observation.count > 0) {
    for (std::size_t i = 0; i < kObservationSize; ++i) {
      const double variance = observation.m2[i] / observation.count;
      snapshot.observation_mean[i] = float(observation.mean[i]);
      snapshot.observation_inv_std[i] = float(1 / std::sqrt(variance + 1e-8));
    }
  }
  return snapshot;
}

}  // namespace

PolicySnapshot SnapshotOf(const TrainState& state, const RunConfig& config) {
  return MakeSnapshot(state.version, state.parameters.data(), ActorLayout(ShapeOf(config)).size,
                      state.observation);
}

PolicySnapshot PreviousSnapshotOf(const TrainState& state, const RunConfig& config) {
  const std::size_t size = ActorLayout(ShapeOf(config)).size;
  if (state.version == 0 || state.previous_actor.size() != size) {
    throw std::logic_error("version " + std::to_string(state.version) +
                           " has no previous snapshot");
  }
  return MakeSnapshot(state.version - 1, state.previous_actor.data(), size,
                      state.previous_observation);
}

}  // namespace metronome
