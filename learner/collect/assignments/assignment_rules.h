#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace metronome::collect::assignments {

/// Limits of what is assigned, and when an assignment counts as late.
struct AssignmentRules {
  std::uint64_t episodes_per_update = 16;  // E
  std::uint64_t overlap = 0;               // batch v is played under weights max(0, v - overlap)
  std::uint64_t updates_total = 1;         // batches 0 .. updates_total - 1 at most
  std::uint64_t first_version = 0;         // updates made before this process
  std::uint32_t assignments_per_env = 2;   // so that no env waits for a round trip
  double late_factor = 3;                  // of the median duration: another idle env is asked too
  double lost_factor = 9;                  // of the median: given up; doubled for each further try
  std::chrono::milliseconds least_late{250};       // shorter lateness is noise
  std::chrono::milliseconds first_estimate{2000};  // of the median, before any was measured
};

/// Weights that episode `number` is played under.
inline std::uint64_t BehaviourVersion(const AssignmentRules& rules, std::uint64_t number) {
  const std::uint64_t batch = number / rules.episodes_per_update;
  return batch - std::min(batch, rules.overlap);
}

}  // namespace metronome::collect::assignments
