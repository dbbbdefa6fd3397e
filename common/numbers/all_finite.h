#pragma once

#include <algorithm>
#include <cmath>
#include <span>

namespace metronome::numbers {

/// @return whether no value is infinite or not a number.
inline bool AllFinite(std::span<const float> values) {
  return std::all_of(values.begin(), values.end(),
                     [](float value) { return std::isfinite(value); });
}

}  // namespace metronome::numbers
