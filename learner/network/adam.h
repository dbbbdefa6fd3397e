#pragma once

#include <cstddef>
#include <cstdint>

namespace metronome::network {

/// One step's constants of Adam (Kingma, Ba, arXiv:1412.6980, algorithm 1).
struct AdamStep {
  float learning_rate = 0;
  float beta1 = 0.9F;
  float beta2 = 0.999F;
  float epsilon = 1e-5F;
  std::uint64_t step = 1;    // t, from 1
  float gradient_scale = 1;  // multiplies the gradient first: the clip by global norm
};

class Adam {
 public:
  explicit Adam(const AdamStep& step);

  /// Updates `count` parameters in place. Elementwise, hence equal bits however a vector is cut.
  void Apply(const float* gradient, float* parameter, float* m, float* v, std::size_t count) const;

 private:
  AdamStep step_;
  float rate_;                  // bias-corrected
  float inv_sqrt_correction2_;  // of v
};

}  // namespace metronome::network
