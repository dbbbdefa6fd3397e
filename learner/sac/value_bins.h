#pragma once

#include <cstddef>
#include <vector>

namespace metronome::sac {

/// Values as distributions over equally spaced bins of symlog(x) = sign(x) ln(1 + |x|): one loss
/// for returns of any size, and a classification in place of a regression (Hafner et al.,
/// arXiv:2301.04104, equations 8 to 11; Farebrother et al., arXiv:2403.03950). A critic's value is
/// the mean of its distribution, in symlog; policies climb that number, so their loss has no scale
/// either (as in Hansen et al., TD-MPC2, arXiv:2310.16828, appendix A, but for the log).
class ValueBins {
 public:
  /// @param bins  at least 2. @param limit  of symlog(x), either side; values beyond count as it.
  ValueBins(std::size_t bins, float limit);

  [[nodiscard]] std::size_t size() const { return bins_.size(); }
  [[nodiscard]] const std::vector<float>& bins() const { return bins_; }  // in symlog, rising

  static float Symlog(float x);
  static float Symexp(float x);

  /// A number in symlog as shares of the two bins around it, which average to it.
  struct TwoHot {
    std::size_t low = 0;  // the other is the next
    float of_low = 1;
    float of_high = 0;
  };
  [[nodiscard]] TwoHot Share(float symlog) const;

  /// Mean in symlog of a distribution. @param probability  [size()].
  [[nodiscard]] float Mean(const float* probability) const;

 private:
  float limit_;
  float width_;  // from bin to bin
  std::vector<float> bins_;
};

/// logits [rows, bins] of a padded matrix become probabilities, by the softmax.
/// @param stride  from row to row; whole panels of a row may be written (common/kernels/product.h).
void Softmax(float* logits, std::size_t rows, std::size_t bins, std::size_t stride);

}  // namespace metronome::sac
