#pragma once

#include <algorithm>
#include <cstdint>

namespace metronome::record {

/// Steps a second, of `steps` in `seconds`; 0 before any time has passed.
inline double StepsPerSecond(std::uint64_t steps, double seconds) {
  return seconds > 0 ? static_cast<double>(steps) / seconds : 0;
}

/// Until `total` at `rate` steps a second; 0 while that is unknown.
inline double SecondsLeft(std::uint64_t steps, std::uint64_t total, double rate) {
  return rate > 0 ? static_cast<double>(total - std::min(steps, total)) / rate : 0;
}

}  // namespace metronome::record
