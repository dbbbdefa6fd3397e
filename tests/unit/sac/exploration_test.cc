#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/numbers/random.h"
#include "common/policy/explorer.h"
#include "learner/sac/sac_state.h"
#include "tests/unit/support/synthetic_run.h"

namespace metronome::sac {
namespace {

using testing::SmallSacConfig;

/// What the noise of an episode's step 7 is multiplied by, from the action.
double FactorOf(const RunConfig& config, std::uint64_t number) {
  policy::Policy policy(config, SnapshotOf(InitialSacState(config), config));
  policy::Policy::Gaussian gaussian;
  gaussian.log_std.fill(-3);
  const auto schedule = policy::HeadSchedule::OfTraining(config, number);
  const auto decision = policy::Explorer(config, number).ActAround(policy, schedule, gaussian, 7);
  numbers::RandomStream random(numbers::RandomPurpose::kTrain, config.seed(), number, 7);
  return std::atanh(double{decision.action[0]}) / (std::exp(-3.0) * random.Normal());
}

TEST(ExplorationTest, EachEpisodeHasAFactorOfItsNoiseAndLogarithmsAreEvenlySpread) {
  RunConfig config = SmallSacConfig();
  config.mutable_sac()->set_noise_spread(3);
  std::vector<double> logs;
  for (std::uint64_t number = 10; number < 60; ++number) {  // after the random ones
    logs.push_back(std::log(FactorOf(config, number)) / std::log(3.0));
  }
  std::sort(logs.begin(), logs.end());
  for (std::size_t i = 0; i < logs.size(); ++i) {
    EXPECT_NEAR(logs[i], -1 + 2 * (double(i) + 0.5) / double(logs.size()), 0.05);
  }
}

TEST(ExplorationTest, WithoutSpreadNoiseIsAsItIs) {
  RunConfig config = SmallSacConfig();
  config.mutable_sac()->set_noise_spread(1);
  for (const std::uint64_t number : {10, 11, 12}) {
    EXPECT_NEAR(FactorOf(config, number), 1, 1e-4);
  }
}

}  // namespace
}  // namespace metronome::sac
