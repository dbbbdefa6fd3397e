#include "learner/ppo/initialise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "tests/unit/support/bits_hash.h"

namespace metronome::ppo {
namespace {

policy::NetworkShape Shape() {
  return {.observation = 39, .hidden = {64, 64}, .heads = 3, .critic_heads = 3, .action = 4};
}

double RowProduct(const float* a, const float* b, std::int32_t size) {
  double sum = 0;
  for (std::int32_t i = 0; i < size; ++i) sum += double{a[i]} * b[i];
  return sum;
}

TEST(InitialiseTest, EachHeadHasRowsOfItsOwnOfTheGainsLength) {
  const policy::NetworkShape shape = Shape();
  const std::vector<float> parameters = InitialParameters(shape, -0.5, 1);
  ASSERT_EQ(parameters.size(), policy::ParameterCount(shape));
  const policy::LayerSlice slice = policy::ActorLayout(shape).head;
  const float* head = parameters.data() + slice.weight;
  for (std::int32_t a = 0; a < shape.heads * shape.action; ++a) {
    for (std::int32_t b = a / shape.action * shape.action; b <= a; ++b) {
      const double product =
          RowProduct(head + a * slice.inputs, head + b * slice.inputs, slice.inputs);
      EXPECT_NEAR(product, a == b ? 1e-4 : 0, 1e-10) << a << " " << b;
    }
  }
  EXPECT_NE(head[0], head[shape.action * slice.inputs]);
}

TEST(InitialiseTest, HiddenLayersHaveGainSqrtTwo) {
  const policy::NetworkShape shape = Shape();
  const std::vector<float> parameters = InitialParameters(shape, -0.5, 1);
  const policy::LayerSlice slice = policy::ActorLayout(shape).hidden[1];
  const float* row = parameters.data() + slice.weight;
  EXPECT_NEAR(RowProduct(row, row, slice.inputs), 2, 1e-6);
  EXPECT_EQ(parameters[slice.bias], 0.0F);
}

TEST(InitialiseTest, LogStdIsAsGiven) {
  const policy::NetworkShape shape = Shape();
  const std::vector<float> parameters = InitialParameters(shape, -0.5, 1);
  EXPECT_EQ(parameters[policy::ActorLayout(shape).log_std], -0.5F);
}

// Every run begins with these. (Orders of sums: tests/unit/numbers/orthogonal_test.cc.)
TEST(InitialiseTest, TheBitsAreFrozen) {
  testing::BitsHash hash;
  for (const float number : InitialParameters(Shape(), -0.5, 1)) hash.Add(number);
  EXPECT_EQ(hash.value(), 0xf3838aaa01d5ab7dU);
}

}  // namespace
}  // namespace metronome::ppo
