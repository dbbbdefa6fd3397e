#pragma once

#include <Eigen/Core>

namespace metronome::policy {

/// tanh of every element, by Eigen's vectorised rational approximation (pure arithmetic, no libm).
/// Takes an owning type only: it starts at an aligned address, so that which elements the vector
/// loop covers - its remainder rounds otherwise - depends on the size alone.
void TanhInPlace(Eigen::MatrixXf& values);

}  // namespace metronome::policy
