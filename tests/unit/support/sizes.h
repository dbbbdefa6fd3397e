#pragma once

/// How large observations and actions are in tests in which nobody plays: as large as Meta-World's.
namespace metronome::test {

inline constexpr int kObservationSize = 39;
inline constexpr int kActionSize = 4;

}  // namespace metronome::test
