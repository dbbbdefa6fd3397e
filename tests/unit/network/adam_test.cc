#include "learner/network/adam.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace metronome::network {
namespace {

// Algorithm 1 of arXiv:1412.6980 in double, written from the paper.
TEST(AdamTest, FollowsThePapersAlgorithmOverManySteps) {
  std::vector<float> parameter = {0.5F, -1.0F, 2.0F};
  std::vector<float> m(3, 0.0F);
  std::vector<float> v(3, 0.0F);
  std::vector<double> want(parameter.begin(), parameter.end());
  std::vector<double> want_m(3, 0.0);
  std::vector<double> want_v(3, 0.0);
  for (int step = 1; step <= 200; ++step) {
    std::vector<float> gradient(3);
    for (int i = 0; i < 3; ++i) gradient[i] = std::sin(0.1F * float(step * (i + 1)));
    AdamStep adam;
    adam.learning_rate = 1e-2F;
    adam.epsilon = 1e-5F;
    adam.step = step;
    adam.gradient_scale = 0.5F;
    Adam(adam).Apply(gradient.data(), parameter.data(), m.data(), v.data(), 3);
    for (int i = 0; i < 3; ++i) {
      const double g = 0.5 * gradient[i];
      want_m[i] = 0.9 * want_m[i] + 0.1 * g;
      want_v[i] = 0.999 * want_v[i] + 0.001 * g * g;
      const double m_hat = want_m[i] / (1 - std::pow(0.9, step));
      const double v_hat = want_v[i] / (1 - std::pow(0.999, step));
      want[i] -= 1e-2 * m_hat / (std::sqrt(v_hat) + 1e-5);
    }
  }
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(parameter[i], want[i], 2e-5) << i;
}

TEST(AdamTest, CuttingTheVectorChangesNoBit) {
  const std::size_t n = 1000;
  std::vector<float> gradient(n);
  for (std::size_t i = 0; i < n; ++i) gradient[i] = std::cos(float(i));
  std::vector<float> whole(n, 1.0F);
  std::vector<float> parts(n, 1.0F);
  std::vector<float> m1(n, 0.1F), v1(n, 0.2F), m2 = m1, v2 = v1;
  const Adam adam({.learning_rate = 1e-3F, .step = 3});
  adam.Apply(gradient.data(), whole.data(), m1.data(), v1.data(), n);
  for (std::size_t begin = 0; begin < n;) {
    const std::size_t count = std::min<std::size_t>(begin % 7 + 1, n - begin);
    adam.Apply(gradient.data() + begin, parts.data() + begin, m2.data() + begin, v2.data() + begin,
               count);
    begin += count;
  }
  EXPECT_EQ(whole, parts);
}

}  // namespace
}  // namespace metronome::network
