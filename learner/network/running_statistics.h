#pragma once

#include <cstddef>
#include <vector>

#include "common/policy/running_statistics.h"

namespace metronome::network {

/// Merges `rows` rows of `dimensions` float32 numbers (row-major, row r at r * stride) into
/// `statistics`, in double precision and row order. Empty statistics take the dimension on.
/// @throws std::invalid_argument if the dimensions differ.
void Merge(policy::RunningStatistics& statistics, const float* values, std::size_t rows,
           std::size_t dimensions, std::size_t stride);

/// All that has been merged counts `factor` times as much from now on, above 0 and at most 1.
void Decay(policy::RunningStatistics& statistics, double factor);

/// Population standard deviation of one dimension; 1 while nothing has been merged.
double StandardDeviation(const policy::RunningStatistics& statistics, std::size_t dimension);

}  // namespace metronome::network
