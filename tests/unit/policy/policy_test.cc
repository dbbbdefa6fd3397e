#include "common/policy/policy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/numbers/random.h"
#include "common/policy/snapshot.h"
#include "learner/ppo/trainer.h"
#include "tests/unit/support/double_network.h"
#include "tests/unit/support/environments.h"
#include "tests/unit/support/synthetic_run.h"

namespace metronome::policy {
namespace {

using testing::SmallConfig;

// The network in double, from its definition: tanh layers, then the rows of one head.
std::vector<double> MeanByDefinition(const RunConfig& config, const PolicySnapshot& snapshot,
                                     const std::vector<float>& observation, int t, int head) {
  const NetworkShape shape = ShapeOf(config);
  std::vector<double> x;
  for (int i = 0; i < shape.observation; ++i) {
    const double z =
        (observation[i] - snapshot.observation_mean[i]) * double{snapshot.observation_inv_std[i]};
    x.push_back(std::fmax(-10, std::fmin(10, z)));
  }
  const int horizon = config.environment().horizon();
  if (shape.time_feature) x.push_back(2.0 * t / horizon - 1);
  return testing::Forward(snapshot.parameters, ActorLayout(shape), x, head);
}

PolicySnapshot RandomSnapshot(const RunConfig& config) {
  PolicySnapshot snapshot = ppo::SnapshotOf(ppo::Trainer::InitialState(config), config);
  numbers::RandomStream random(numbers::RandomPurpose::kEvaluate, 1, 2, 3);
  for (float& parameter : snapshot.parameters) parameter += 0.2F * float(random.Normal());
  for (float& mean : snapshot.observation_mean) mean = float(random.Normal());
  for (float& inv_std : snapshot.observation_inv_std) inv_std = float(0.5 + random.Uniform());
  return snapshot;
}

/// The head of step t in episode 6 of SmallConfig (T = 40, k = 3 or 1, seed 5), by definition.
int HeadByDefinition(const RunConfig& config, int t) {
  const int heads = config.policy().heads();
  if (config.policy().schedule() == SCHEDULE_INTERLEAVED) return t % heads;
  const int block = t * heads / 40;
  if (config.policy().schedule() == SCHEDULE_BLOCKS) return block;
  return int(numbers::Permutation(std::uint32_t(heads), {numbers::RandomPurpose::kHeadPermutation,
                                                         5, 6, 1 /* kTrain */})[block]);
}

HeadSchedule ScheduleOfSix(const RunConfig& config) { return HeadSchedule::OfTraining(config, 6); }

class PolicyTest : public ::testing::TestWithParam<std::pair<Method, Schedule>> {
 protected:
  static RunConfig Config() {
    RunConfig config = SmallConfig(GetParam().first);
    config.mutable_policy()->set_schedule(GetParam().second);
    return config;
  }
};

TEST_P(PolicyTest, MeanAgreesWithTheNetworksDefinitionAtEveryStep) {
  const RunConfig config = Config();
  const HeadSchedule schedule = ScheduleOfSix(config);
  const PolicySnapshot snapshot = RandomSnapshot(config);
  Policy policy(config, snapshot);
  numbers::RandomStream random(numbers::RandomPurpose::kEvaluate, 4, 5, 6);
  for (int t = 0; t < config.environment().horizon(); ++t) {
    std::vector<float> observation(test::kObservationSize);
    for (float& value : observation) value = float(3 * random.Normal());
    const auto mean = policy.Mean(schedule, observation.data(), t);
    const auto want =
        MeanByDefinition(config, snapshot, observation, t, HeadByDefinition(config, t));
    for (int i = 0; i < 4; ++i) ASSERT_NEAR(mean[i], want[i], 1e-5) << "t=" << t;
  }
}

TEST_P(PolicyTest, SeveralStepsTogetherGiveTheBitsOfEachAlone) {
  const RunConfig config = Config();
  const HeadSchedule schedule = ScheduleOfSix(config);
  Policy policy(config, RandomSnapshot(config));
  numbers::RandomStream random(numbers::RandomPurpose::kEvaluate, 4, 5, 7);
  for (int count = 1; count <= int(Policy::kMostStates); ++count) {
    std::vector<float> observations(std::size_t(count) * test::kObservationSize);
    std::vector<Policy::Gaussian> gaussians{std::size_t(count)};
    for (int t = 0; t + count <= config.environment().horizon(); t += 7) {
      for (float& value : observations) value = float(3 * random.Normal());
      policy.Gaussians(schedule, observations.data(), t, gaussians);
      for (int i = 0; i < count; ++i) {
        EXPECT_EQ(gaussians[std::size_t(i)].mean,
                  policy.Mean(schedule, observations.data() + i * test::kObservationSize, t + i));
      }
    }
  }
}

TEST_P(PolicyTest, TheLogProbabilityIsTheUnclippedActionsDensity) {
  const RunConfig config = Config();
  const HeadSchedule schedule = ScheduleOfSix(config);
  const PolicySnapshot snapshot = RandomSnapshot(config);
  Policy policy(config, snapshot);
  const std::vector<float> observation(test::kObservationSize, 0.4F);
  const std::size_t log_std = ActorLayout(ShapeOf(config)).log_std;
  for (const int t : {0, 20, 39}) {
    const Policy::Decision decision =
        policy.Act(schedule, observation.data(), t, {0.5F, -1.0F, 2.0F, 0.1F});
    EXPECT_EQ(decision.head, HeadByDefinition(config, t));
    double want = 0;
    for (int i = 0; i < 4; ++i) {
      const double s = snapshot.parameters[log_std + decision.head * 4 + i];
      const double z = (double{decision.action[i]} - decision.mean[i]) / std::exp(s);
      want += -0.5 * z * z - s - 0.5 * std::log(2 * M_PI);
    }
    EXPECT_NEAR(decision.log_prob, want, 1e-5);
  }
}

INSTANTIATE_TEST_SUITE_P(MethodsAndSchedules, PolicyTest,
                         ::testing::Values(std::pair{MULTIHEAD, SCHEDULE_BLOCKS},
                                           std::pair{MULTIHEAD, SCHEDULE_INTERLEAVED},
                                           std::pair{MULTIHEAD, SCHEDULE_SHUFFLED},
                                           std::pair{SINGLE, SCHEDULE_BLOCKS},
                                           std::pair{SINGLE_TIME, SCHEDULE_BLOCKS},
                                           std::pair{SINGLE_TIME, SCHEDULE_SHUFFLED}));

TEST(PolicyTest, ActingTwiceOrAfterOtherStatesGivesEqualBits) {
  const RunConfig config = SmallConfig();
  const PolicySnapshot snapshot = RandomSnapshot(config);
  Policy fresh(config, snapshot);
  Policy used(config, snapshot);
  const std::vector<float> other(test::kObservationSize, -1.0F);
  const std::vector<float> observation(test::kObservationSize, 0.7F);
  const HeadSchedule schedule = ScheduleOfSix(config);
  for (int t = 0; t < 40; ++t) (void)used.Act(schedule, other.data(), t, {1, 1, 1, 1});
  const auto a = fresh.Act(schedule, observation.data(), 17, {0.5F, -1.0F, 2.0F, 0.1F});
  const auto b = used.Act(schedule, observation.data(), 17, {0.5F, -1.0F, 2.0F, 0.1F});
  EXPECT_EQ(a.action, b.action);
  EXPECT_EQ(a.log_prob, b.log_prob);
}

TEST(PolicyTest, RefusesASnapshotOfAnotherShape) {
  PolicySnapshot snapshot = RandomSnapshot(SmallConfig());
  snapshot.parameters.pop_back();
  EXPECT_THROW(Policy(SmallConfig(), snapshot), std::invalid_argument);
}

/// The decision of step 0 on observations of `observed` each.
Policy::Decision DecideOn(const RunConfig& config, const PolicySnapshot& snapshot, float observed) {
  Policy policy(config, snapshot);
  const auto schedule = HeadSchedule::OfTraining(config, 0);
  const std::vector<float> observation(test::kObservationSize, observed);
  return policy.Act(schedule, observation.data(), 0, {8.5F, -8.5F, 0.5F, 0.0F});
}

TEST(SnapshotDefectTest, WhatIsLargeAndAcceptedStillActsFinitely) {
  const RunConfig config = SmallConfig();
  const std::size_t log_std = ActorLayout(ShapeOf(config)).log_std;
  for (const float largest : {1e20F, -1e20F}) {
    for (const float log_std_value : {46.0F, -46.0F}) {
      PolicySnapshot snapshot = RandomSnapshot(config);
      std::fill(snapshot.parameters.begin(), snapshot.parameters.end(), largest);
      std::fill(snapshot.parameters.begin() + std::ptrdiff_t(log_std), snapshot.parameters.end(),
                log_std_value);
      std::fill(snapshot.observation_inv_std.begin(), snapshot.observation_inv_std.end(), 1e20F);
      EXPECT_EQ(SnapshotDefect(snapshot, config), std::nullopt);
      const Policy::Decision decision = DecideOn(config, snapshot, 3.0F);
      for (const float component : decision.action) EXPECT_TRUE(std::isfinite(component));
      EXPECT_TRUE(std::isfinite(decision.log_prob));
    }
  }
}

TEST(SnapshotDefectTest, NamesWhatNoActorCanActWith) {
  const RunConfig config = SmallConfig();
  const auto defect = [&config](const auto& spoil) {
    PolicySnapshot snapshot = RandomSnapshot(config);
    spoil(snapshot);
    return SnapshotDefect(snapshot, config).value_or("none");
  };
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(defect([](PolicySnapshot&) {}), "none");
  EXPECT_NE(defect([](PolicySnapshot& s) { s.parameters.pop_back(); }).find("parameters"),
            std::string::npos);
  EXPECT_NE(defect([](PolicySnapshot& s) { s.observation_mean.pop_back(); }).find("statistics"),
            std::string::npos);
  for (const float value : {2e20F, -3e38F, infinity, std::nanf("")}) {
    EXPECT_TRUE(defect([&](PolicySnapshot& s) {
                  s.parameters.front() = value;
                }).starts_with("a parameter is "))
        << value;
    EXPECT_TRUE(defect([&](PolicySnapshot& s) {
                  s.observation_inv_std[3] = value;
                }).starts_with("an observation statistic is "))
        << value;
  }
  for (const float value : {46.5F, 88.0F, -46.5F, -infinity, std::nanf("")}) {
    EXPECT_TRUE(defect([&](PolicySnapshot& s) {
                  s.parameters.back() = value;
                }).starts_with("a log-std is "))
        << value;
  }
}

TEST(PolicyTest, RefusesAScheduleOfAnotherNumberOfHeads) {
  Policy policy(SmallConfig(), RandomSnapshot(SmallConfig()));
  const HeadSchedule four = ScheduleOfSix(SmallConfig(MULTIHEAD, 4));
  const std::vector<float> observation(test::kObservationSize, 0.4F);
  Policy::Gaussian gaussian;
  EXPECT_THROW((void)policy.Mean(four, observation.data(), 0), std::invalid_argument);
  EXPECT_THROW(policy.Gaussians(four, observation.data(), 0, {&gaussian, 1}),
               std::invalid_argument);
  EXPECT_THROW((void)policy.ActAround(four, {}, 0, {}), std::invalid_argument);
}

// An input that was constant in training may move later: what it is multiplied by is bounded.
TEST(SnapshotTest, AddsTheConfiguredEpsilonToTheVariance) {
  RunConfig config = SmallConfig();
  ppo::PpoState state = ppo::Trainer::InitialState(config);
  state.observation = {{std::vector<double>(39, 0), std::vector<double>(39, 0), 100}};
  state.observation[0].m2[1] = 300;
  EXPECT_EQ(ppo::SnapshotOf(state, config).observation_inv_std[0], 1e4F) << "as ever, by default";
  config.mutable_policy()->set_observation_epsilon(1e-4);
  const PolicySnapshot snapshot = ppo::SnapshotOf(state, config);
  EXPECT_FLOAT_EQ(snapshot.observation_inv_std[0], 100);
  EXPECT_FLOAT_EQ(snapshot.observation_inv_std[1], float(1 / std::sqrt(3 + 1e-4)));
}

}  // namespace
}  // namespace metronome::policy
