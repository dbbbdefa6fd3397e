#pragma once

#include "common/kernels/product.h"

namespace metronome::kernels {

/// The kernels of one instruction set; what they do: product.h.
struct KernelTable {
  void (*multiply)(const Product&);
  void (*tanh)(float* values, const Block&);
  void (*times_tanh_slope)(const float* y, float* d, const Block&);
  void (*exp)(float* values, const Block&);
};

}  // namespace metronome::kernels
