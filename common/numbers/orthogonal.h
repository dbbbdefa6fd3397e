#pragma once

#include <cstdint>
#include <vector>

#include "common/numbers/random.h"

namespace metronome::numbers {

/// A random matrix whose rows are orthonormal (its columns, where it has more rows than columns),
/// in row-major order. All such matrices are equally likely. Plain arithmetic in one order: equal
/// bits wherever it is compiled without contraction.
/// @param random  its normal numbers are used one after the other, rows * columns of them.
std::vector<double> Orthogonal(std::int32_t rows, std::int32_t columns, RandomStream random);

}  // namespace metronome::numbers
