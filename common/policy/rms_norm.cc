#include "common/policy/rms_norm.h"

#include <array>
#include <cmath>

#include "common/kernels/product.h"

namespace metronome::policy {
namespace {

using kernels::kPanel;

constexpr float kEpsilon = 1e-5F;

float Dot(const float* a, const float* b, std::size_t size) {
  std::array<float, kPanel> chains{};
  for (std::size_t i = 0; i < size; i += kPanel) {
    for (std::size_t c = 0; c < kPanel; ++c) chains[c] += a[i + c] * b[i + c];
  }
  float sum = 0;
  for (const float chain : chains) sum += chain;
  return sum;
}

}  // namespace

float NormaliseByRms(float* row, std::size_t size) {
  const float inv_rms = 1 / std::sqrt(Dot(row, row, size) / float(size) + kEpsilon);
  for (std::size_t i = 0; i < size; ++i) row[i] *= inv_rms;
  return inv_rms;
}

// y = x r, r = (mean of x^2 + epsilon)^(-1/2): dL/dx = r (d - y * mean of y d).
void BackThroughRms(const float* row, float inv_rms, float* d, std::size_t size) {
  const float mean = Dot(row, d, size) / float(size);
  for (std::size_t i = 0; i < size; ++i) d[i] = inv_rms * (d[i] - row[i] * mean);
}

}  // namespace metronome::policy
