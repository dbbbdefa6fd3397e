#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace metronome::record {

/// How long a run is to be, for people. Where episodes end early each update brings as many steps
/// as it does, so the number of updates is known at the end alone.
struct RunLength {
  std::uint64_t total_steps = 0;  // of the environment
  std::uint64_t updates = 0;      // the fewest that reach them
  bool varies = false;            // it may take more

  /// Updates of the whole run: as many as there are if it does not vary, else as many as it takes
  /// if updates go on to bring the steps that they brought so far.
  [[nodiscard]] std::uint64_t UpdatesAt(std::uint64_t version, std::uint64_t steps) const {
    if (!varies || steps == 0) return updates;
    const auto left = static_cast<double>(total_steps - std::min(steps, total_steps));
    const double more = left * static_cast<double>(version) / static_cast<double>(steps);
    return version + static_cast<std::uint64_t>(std::ceil(more));
  }
};

}  // namespace metronome::record
