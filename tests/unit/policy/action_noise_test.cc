#include "common/policy/action_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/numbers/random.h"
#include "tests/unit/support/environments.h"

namespace metronome::policy {
namespace {

RunConfig ConfigWith(double correlation, std::uint64_t seed = 5) {
  RunConfig config;
  config.set_seed(seed);
  test::SetTask(config, "push");
  config.mutable_policy()->set_noise_correlation(correlation);
  return config;
}

// One component over many steps of one episode.
std::vector<double> Sequence(double correlation, int component, int steps) {
  ActionNoise noise(ConfigWith(correlation), 3);
  std::vector<double> sequence;
  for (int t = 0; t < steps; ++t) sequence.push_back(noise.At(t)[component]);
  return sequence;
}

double MeanProduct(const std::vector<double>& sequence, int lag) {
  double sum = 0;
  const auto count = static_cast<int>(sequence.size()) - lag;
  for (int t = 0; t < count; ++t) sum += sequence[t] * sequence[t + lag];
  return sum / count;
}

TEST(ActionNoiseTest, WhiteNoiseIsTheStreamOfTheStepItself) {
  ActionNoise noise(ConfigWith(0), 9);
  for (const int t : {0, 17, 4}) {
    numbers::RandomStream stream(numbers::RandomPurpose::kTrain, 5, 9, std::uint64_t(t));
    const ActionNoise::Numbers numbers = noise.At(t);
    for (int i = 0; i < test::kActionSize; ++i) {
      EXPECT_EQ(numbers[i], static_cast<float>(stream.Normal()));
    }
  }
}

TEST(ActionNoiseTest, FollowsTheRecursionOfIndependentNumbers) {
  const double rho = 0.8;
  ActionNoise noise(ConfigWith(rho), 9);
  std::array<double, test::kActionSize> want{};
  for (int t = 0; t < 30; ++t) {
    numbers::RandomStream stream(numbers::RandomPurpose::kTrain, 5, 9, std::uint64_t(t));
    const ActionNoise::Numbers numbers = noise.At(t);
    for (int i = 0; i < test::kActionSize; ++i) {
      const double fresh = stream.Normal();
      want[i] = t == 0 ? fresh : rho * want[i] + 0.6 * fresh;  // 0.6^2 + 0.8^2 = 1
      EXPECT_NEAR(numbers[i], want[i], 1e-6) << "t = " << t;
    }
  }
}

TEST(ActionNoiseTest, IsTheSameInWhateverOrderItIsAsked) {
  ActionNoise forward(ConfigWith(0.9), 1);
  std::vector<ActionNoise::Numbers> want;
  for (int t = 0; t < 40; ++t) want.push_back(forward.At(t));
  ActionNoise jumping(ConfigWith(0.9), 1);
  for (const int t : {39, 0, 12, 12, 5, 38}) EXPECT_EQ(jumping.At(t), want[t]) << "t = " << t;
}

// 20000 steps: the standard error of a mean product of white noise is 0.007, of noise with
// correlation 0.9 about 0.03.
TEST(ActionNoiseTest, HasUnitVarianceAndTheCorrelationAsked) {
  const std::vector<double> white = Sequence(0, 2, 20000);
  EXPECT_NEAR(MeanProduct(white, 0), 1, 0.04);
  EXPECT_NEAR(MeanProduct(white, 1), 0, 0.03);
  const std::vector<double> slow = Sequence(0.9, 2, 20000);
  EXPECT_NEAR(MeanProduct(slow, 0), 1, 0.12);
  EXPECT_NEAR(MeanProduct(slow, 1) / MeanProduct(slow, 0), 0.9, 0.02);
  EXPECT_NEAR(MeanProduct(slow, 10) / MeanProduct(slow, 0), std::pow(0.9, 10), 0.1);
}

TEST(ActionNoiseTest, EpisodesAndSeedsHaveTheirOwn) {
  const auto first = [](std::uint64_t seed, std::uint64_t number) {
    return ActionNoise(ConfigWith(0.5, seed), number).At(7);
  };
  EXPECT_NE(first(1, 1), first(1, 2));
  EXPECT_NE(first(1, 1), first(2, 1));
  EXPECT_EQ(first(1, 1), first(1, 1));
}

}  // namespace
}  // namespace metronome::policy
