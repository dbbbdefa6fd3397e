#include "learner/ppo/gae.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <random>
#include <stdexcept>
#include <vector>

namespace metronome::ppo {
namespace {

// Oracle: the definition, sum over l of (gamma lambda)^l delta_{t+l}, in O(T^2) and without the
// recursion that is under test.
double AdvantageByDefinition(const std::vector<float>& reward, const std::vector<float>& value,
                             double final_value, double gamma, double lambda, std::size_t t) {
  double advantage = 0;
  double weight = 1;
  for (std::size_t l = t; l < reward.size(); ++l) {
    const double next = l + 1 < value.size() ? value[l + 1] : final_value;
    advantage += weight * (reward[l] + gamma * next - value[l]);
    weight *= gamma * lambda;
  }
  return advantage;
}

TEST(GaeTest, EqualsItsDefinitionWithAndWithoutAFinalValue) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  for (const float final_value : {0.0F, 1.7F}) {
    std::vector<float> reward(57);
    std::vector<float> value(57);
    for (float& r : reward) r = normal(random);
    for (float& v : value) v = normal(random);
    const GaeResult result = ComputeGae(reward, value, final_value, {0.97, 0.8});
    for (std::size_t t = 0; t < reward.size(); ++t) {
      const double want = AdvantageByDefinition(reward, value, final_value, 0.97, 0.8, t);
      EXPECT_NEAR(result.advantage[t], want, 1e-5) << "t=" << t;
      EXPECT_NEAR(result.target[t], want + value[t], 1e-5) << "t=" << t;
    }
  }
}

TEST(GaeTest, WithLambdaOneTheTargetIsTheDiscountedReturn) {
  const GaeResult result = ComputeGae({1, 2, 3}, {5, -4, 9}, 0, {0.5, 1});
  EXPECT_NEAR(result.target[2], 3, 1e-6);
  EXPECT_NEAR(result.target[1], 2 + 0.5 * 3, 1e-6);
  EXPECT_NEAR(result.target[0], 1 + 0.5 * (2 + 0.5 * 3), 1e-6);
}

TEST(GaeTest, RefusesUnequalLengths) {
  EXPECT_THROW(ComputeGae({1, 2}, {1}, 0, {}), std::invalid_argument);
}

}  // namespace
}  // namespace metronome::ppo
