#include "learner/network/adam.h"

#include <cmath>

#include "common/numbers/elementary.h"

namespace metronome::network {
namespace {

float Correction(float beta, std::uint64_t step) {
  return static_cast<float>(1.0 - numbers::Pow(double{beta}, static_cast<double>(step)));
}

}  // namespace

Adam::Adam(const AdamStep& step)
    : step_(step),
      rate_(step.learning_rate / Correction(step.beta1, step.step)),
      inv_sqrt_correction2_(1.0F / std::sqrt(Correction(step.beta2, step.step))) {}

void Adam::Apply(const float* __restrict gradient, float* __restrict parameter, float* __restrict m,
                 float* __restrict v, std::size_t count) const {
  const AdamStep adam = step_;
  const float rate = rate_;
  const float inv_sqrt_correction2 = inv_sqrt_correction2_;
  for (std::size_t i = 0; i < count; ++i) {
    const float g = gradient[i] * adam.gradient_scale;
    m[i] = adam.beta1 * m[i] + (1.0F - adam.beta1) * g;
    v[i] = adam.beta2 * v[i] + (1.0F - adam.beta2) * (g * g);
    parameter[i] -= rate * m[i] / (std::sqrt(v[i]) * inv_sqrt_correction2 + adam.epsilon);
  }
}

}  // namespace metronome::network
