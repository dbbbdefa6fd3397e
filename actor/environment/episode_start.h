#pragma once

#include <cstdint>

#include "common/numbers/episode_key.h"
#include "common/numbers/random.h"
#include "common/schema/config.pb.h"

namespace metronome::environment {

/// Where an episode starts, and all that is random about it.
struct EpisodeStart {
  explicit EpisodeStart(const numbers::EpisodeKey& episode)
      : key(episode),
        random(episode.purpose, episode.seed, episode.number, numbers::kPlacementDraw) {}

  numbers::EpisodeKey key;
  numbers::RandomStream
      random;  // the episode's own; what is drawn from it is drawn alike everywhere
};

/// Of episode `number` of a training run. With fixed placements all start as number 0 does.
inline EpisodeStart TrainingStart(const RunConfig& config, std::uint64_t number) {
  const bool fixed = config.environment().placements() == PLACEMENTS_FIXED;
  return EpisodeStart({numbers::RandomPurpose::kTrain, config.seed(), fixed ? 0 : number});
}

}  // namespace metronome::environment
