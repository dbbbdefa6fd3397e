#include "common/kernels/matrix.h"

#include <algorithm>

#include "common/kernels/product.h"

namespace metronome::kernels {
namespace {

// Whole panels; never a multiple of 256 bytes, at which the rows of a tile would share a few sets
// of the first cache.
std::size_t StrideOf(std::size_t columns) {
  const std::size_t panels = PanelsOf(columns);
  return (panels % 4 == 0 ? panels + 1 : panels) * kPanel;
}

}  // namespace

void Matrix::Resize(std::size_t rows, std::size_t columns) {
  if (rows == rows_ && columns == columns_ && data_) return;
  rows_ = rows;
  columns_ = columns;
  stride_ = StrideOf(columns);
  const std::size_t size = std::max<std::size_t>(1, rows * stride_);
  data_.reset(new (kAlignment) float[size]());
}

}  // namespace metronome::kernels
