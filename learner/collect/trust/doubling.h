#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace metronome::collect::trust {

/// A time that grows with each of `times` repetitions: 0 for none, `first` for one, then twice as
/// much each time, at most `longest`.
inline std::chrono::milliseconds Doubling(std::uint32_t times, std::chrono::milliseconds first,
                                          std::chrono::milliseconds longest) {
  if (times == 0) return std::chrono::milliseconds(0);
  std::chrono::milliseconds grown = first;
  for (std::uint32_t i = 1; i < times && grown < longest; ++i) grown *= 2;
  return std::min(grown, longest);
}

}  // namespace metronome::collect::trust
