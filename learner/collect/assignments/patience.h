#pragma once

#include <chrono>
#include <cstdint>

#include "learner/collect/assignments/assignment_rules.h"
#include "learner/collect/assignments/duration_median.h"

namespace metronome::collect::assignments {

/// How long an assignment may take, by how long the last ones took. Not thread-safe.
class Patience {
 public:
  explicit Patience(const AssignmentRules& rules) : rules_(rules) {}

  /// An episode took this long.
  void Learn(std::chrono::nanoseconds duration) { durations_.Add(duration); }
  /// An assignment that is this old is late: another is asked too.
  [[nodiscard]] std::chrono::nanoseconds Late() const { return Scaled(rules_.late_factor); }
  /// And lost with this age. @param tries  times that its number was handed out; at least 1.
  [[nodiscard]] std::chrono::nanoseconds Lost(std::uint32_t tries) const;

 private:
  [[nodiscard]] std::chrono::nanoseconds Scaled(double factor) const;

  AssignmentRules rules_;
  DurationMedian durations_;
};

}  // namespace metronome::collect::assignments
