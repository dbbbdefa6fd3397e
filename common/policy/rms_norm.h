#pragma once

#include <cstddef>

namespace metronome::policy {

/// Divides a row by its root mean square, without learnt factors (RMSNorm: Zhang, Sennrich,
/// arXiv:1910.07467, equation 4). Sums have 16 chains, each in order, so bits depend on no
/// processor.
/// @param row  [size], padded with zeros to a multiple of 16.
/// @return 1 / sqrt(mean of squares + 1e-5).
float NormaliseByRms(float* row, std::size_t size);

/// Back through it: d becomes the gradient by what the row was before.
/// @param row      as NormaliseByRms left it. @param inv_rms  what that returned.
/// @param d        [size], the gradient by the row; padded as the row.
void BackThroughRms(const float* row, float inv_rms, float* d, std::size_t size);

}  // namespace metronome::policy
