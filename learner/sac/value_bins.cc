#include "learner/sac/value_bins.h"

#include <algorithm>
#include <cmath>

#include "common/kernels/product.h"
#include "common/numbers/elementary.h"

namespace metronome::sac {

ValueBins::ValueBins(std::size_t bins, float limit)
    : limit_(limit), width_(2 * limit / float(bins - 1)) {
  for (std::size_t i = 0; i < bins; ++i) bins_.push_back(-limit + width_ * float(i));
}

float ValueBins::Symlog(float x) {
  return std::copysign(float(numbers::Log(1 + std::abs(double{x}))), x);
}

float ValueBins::Symexp(float x) {
  return std::copysign(float(numbers::Exp(std::abs(double{x})) - 1), x);
}

ValueBins::TwoHot ValueBins::Share(float symlog) const {
  const float at = (std::clamp(symlog, -limit_, limit_) + limit_) / width_;
  TwoHot share;
  share.low = std::min(std::size_t(at), bins_.size() - 2);
  share.of_high = std::clamp(at - float(share.low), 0.0F, 1.0F);
  share.of_low = 1 - share.of_high;
  return share;
}

float ValueBins::Mean(const float* probability) const {
  float mean = 0;
  for (std::size_t i = 0; i < bins_.size(); ++i) mean += probability[i] * bins_[i];
  return mean;
}

void Softmax(float* logits, std::size_t rows, std::size_t bins, std::size_t stride) {
  for (std::size_t r = 0; r < rows; ++r) {
    float* row = logits + r * stride;
    const float largest = *std::max_element(row, row + bins);
    std::transform(row, row + bins, row, [largest](float value) { return value - largest; });
    kernels::Exp(row, {1, bins, stride});
    float sum = 0;
    for (std::size_t i = 0; i < bins; ++i) sum += row[i];
    const float scale = 1 / sum;
    std::transform(row, row + bins, row, [scale](float value) { return value * scale; });
  }
}

}  // namespace metronome::sac
