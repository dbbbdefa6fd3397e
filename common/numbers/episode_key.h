#pragma once

#include <cstdint>

#include "common/numbers/random.h"

namespace metronome::numbers {

/// Which episode: the key of what is drawn anew for each.
struct EpisodeKey {
  RandomPurpose purpose = RandomPurpose::kTrain;  // or kEvaluate
  std::uint64_t seed = 0;                         // of the run, or of the evaluation
  std::uint64_t number = 0;                       // in it, from 0
};

}  // namespace metronome::numbers
