#pragma once

#include <vector>

namespace metronome::policy {

/// Mean and variance of a stream, merged batch by batch in double precision
/// (Chan, Golub, LeVeque 1979, parallel form). One entry per dimension.
struct RunningStatistics {
  std::vector<double> mean;
  std::vector<double> m2;  // sum of squared deviations
  double count = 0;
  bool operator==(const RunningStatistics&) const = default;
};

}  // namespace metronome::policy
