#include "learner/ppo/adam.h"

#include <cmath>

namespace metronome::ppo {

void ApplyAdam(const AdamStep& adam, const float* __restrict gradient, float* __restrict parameter,
               float* __restrict m, float* __restrict v, std::size_t count) {
  const auto t = static_cast<double>(adam.step);
  const auto correction1 = static_cast<float>(1.0 - std::pow(double{adam.beta1}, t));
  const auto correction2 = static_cast<float>(1.0 - std::pow(double{adam.beta2}, t));
  const float rate = adam.learning_rate / correction1;
  const float inv_sqrt_correction2 = 1.0F / std::sqrt(correction2);
  for (std::size_t i = 0; i < count; ++i) {
    const float g = gradient[i] * adam.gradient_scale;
    m[i] = adam.beta1 * m[i] + (1.0F - adam.beta1) * g;
    v[i] = adam.beta2 * v[i] + (1.0F - adam.beta2) * (g * g);
    parameter[i] -= rate * m[i] / (std::sqrt(v[i]) * inv_sqrt_correction2 + adam.epsilon);
  }
}

}  // namespace metronome::ppo
