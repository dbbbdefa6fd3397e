#include "learner/ppo/minibatch_step.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "learner/algorithm/algorithm.h"
#include "learner/ppo/trainer.h"
#include "tests/unit/support/double_network.h"
#include "tests/unit/support/synthetic_run.h"

namespace metronome::ppo {
namespace {

using testing::Forward;
using testing::SmallConfig;
using testing::SyntheticBatch;

// The whole minibatch's PPO loss in double, written from the formulas of the design: clipped
// surrogate of advantages normalised in the minibatch, entropy bonus, half squared value error.
double Loss(const RunConfig& config, const TrainingBatch& batch,
            const std::vector<std::uint32_t>& samples, const std::vector<double>& parameters,
            double entropy_coefficient) {
  const policy::MlpLayout actor = policy::ActorLayout(policy::ShapeOf(config));
  const policy::MlpLayout critic = policy::CriticLayout(policy::ShapeOf(config));
  const std::vector<double> of_actor(parameters.begin(), parameters.begin() + actor.size);
  const std::vector<double> of_critic(parameters.begin() + actor.size, parameters.end());
  double mean = 0;
  double variance = 0;
  for (const auto s : samples) mean += batch.advantage[s] / double(samples.size());
  for (const auto s : samples) variance += std::pow(batch.advantage[s] - mean, 2);
  const double deviation = std::sqrt(variance / double(samples.size() - 1));
  double loss = 0;
  for (const auto s : samples) {
    std::vector<double> x(batch.input.row(s), batch.input.row(s) + batch.input.columns());
    const auto mu = Forward(of_actor, actor, x, batch.head[s]);
    double log_prob = 0;
    double entropy = 0;
    for (int i = 0; i < 4; ++i) {
      const double log_std = of_actor[actor.log_std + batch.head[s] * 4 + i];
      const double z = (batch.action.row(s)[i] - mu[i]) / std::exp(log_std);
      log_prob += -0.5 * z * z - log_std - 0.5 * std::log(2 * M_PI);
      entropy += log_std + 0.5 * std::log(2 * M_PI * std::exp(1.0));
    }
    const double ratio = std::exp(log_prob - batch.proximal_log_prob[s]);
    const double weight = std::exp(batch.proximal_log_prob[s] - batch.behaviour_log_prob[s]);
    const double advantage = (batch.advantage[s] - mean) / (deviation + 1e-8);
    const double clip = config.ppo().clip();
    const double clipped = std::fmax(1 - clip, std::fmin(1 + clip, ratio));
    const bool shared = config.policy().critic_heads() == CRITIC_HEADS_SHARED;
    const int value_head = shared ? 0 : batch.head[s];
    const auto values = Forward(of_critic, critic, x, value_head);
    double errors = 0;
    for (std::size_t part = 0; part < batch.rewards.size(); ++part) {
      errors += std::pow(values[part] - batch.rewards[part].target[s], 2);
    }
    loss += -weight * std::fmin(ratio * advantage, clipped * advantage) -
            entropy_coefficient * entropy + config.ppo().value_coefficient() * 0.5 * errors;
  }
  return loss / double(samples.size());
}

struct Prepared {
  TrainingBatch batch;
  OptimiserState state;
  std::vector<std::uint32_t> samples;
};

// A batch whose ratios are spread around 1, so that every branch of the clip occurs.
Prepared Prepare(const RunConfig& config, network::WorkerTeam& team) {
  PpoState initial = Trainer::InitialState(config);
  const PolicySnapshot snapshot = SnapshotOf(initial, config);
  const auto episodes = SyntheticBatch(config, snapshot, 0);
  Prepared prepared{
      BuildBatch({config, episodes, 0, snapshot, initial.parameters.data(), {0.7F, 0.4F}}, team),
      {initial.parameters, initial.adam_m, initial.adam_v, 0, initial.shared},
      std::vector<std::uint32_t>(150)};
  numbers::RandomStream random(numbers::RandomPurpose::kEvaluate, 8, 8, 8);
  for (float& parameter : prepared.state.parameters) parameter += 0.02F * float(random.Normal());
  for (std::size_t s = 0; s < prepared.batch.size(); ++s) {
    float& behaviour = prepared.batch.behaviour_log_prob[s];
    behaviour += 0.1F * float(random.Normal());
    prepared.batch.behaviour_weight[s] = std::exp(prepared.batch.proximal_log_prob[s] - behaviour);
  }
  std::iota(prepared.samples.begin(), prepared.samples.end(), 100U);
  return prepared;
}

struct Arm {
  Method method = MULTIHEAD;
  Schedule schedule = SCHEDULE_BLOCKS;
  CriticHeads critic_heads = CRITIC_HEADS_SEPARATE;
  double success_weight = 0;  // above 0: two values
};

class GradientTest : public ::testing::TestWithParam<Arm> {};

TEST_P(GradientTest, AgreesWithFiniteDifferencesOfAnIndependentLoss) {
  RunConfig config = SmallConfig(GetParam().method);
  config.mutable_policy()->set_schedule(GetParam().schedule);
  config.mutable_policy()->set_critic_heads(GetParam().critic_heads);
  config.mutable_environment()->set_reward(REWARD_SUCCESS);
  config.mutable_ppo()->set_success_weight(GetParam().success_weight);
  network::WorkerTeam team(1);
  Prepared prepared = Prepare(config, team);
  const std::vector<double> at(prepared.state.parameters.begin(), prepared.state.parameters.end());
  MinibatchStep step(config, team);
  step.Begin(prepared.state);
  const double entropy_coefficient = 0.03;
  const MinibatchSums sums =
      step.Run(prepared.batch, prepared.samples, {1e-3, entropy_coefficient}, prepared.state);
  double clipped = 0;
  for (const HeadSums& head : sums.heads) clipped += head.clipped;
  ASSERT_GT(clipped, 5);
  ASSERT_LT(clipped, 145);
  double square = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const double h = 1e-5;
    std::vector<double> up = at;
    std::vector<double> down = at;
    up[i] += h;
    down[i] -= h;
    const double want =
        (Loss(config, prepared.batch, prepared.samples, up, entropy_coefficient) -
         Loss(config, prepared.batch, prepared.samples, down, entropy_coefficient)) /
        (2 * h);
    ASSERT_NEAR(step.gradient()[i], want, 2e-5 + 1e-3 * std::abs(want)) << "parameter " << i;
    square += double{step.gradient()[i]} * step.gradient()[i];
  }
  EXPECT_NEAR(sums.gradient_norm, std::sqrt(square), 1e-5);
}

INSTANTIATE_TEST_SUITE_P(
    Arms, GradientTest,
    ::testing::Values(Arm{MULTIHEAD}, Arm{SINGLE}, Arm{SINGLE_TIME},
                      Arm{MULTIHEAD, SCHEDULE_BLOCKS, CRITIC_HEADS_SEPARATE, 2},
                      Arm{SINGLE, SCHEDULE_BLOCKS, CRITIC_HEADS_SEPARATE, 2},
                      Arm{MULTIHEAD, SCHEDULE_BLOCKS, CRITIC_HEADS_SHARED},
                      Arm{MULTIHEAD, SCHEDULE_INTERLEAVED, CRITIC_HEADS_SEPARATE},
                      Arm{MULTIHEAD, SCHEDULE_SHUFFLED, CRITIC_HEADS_SHARED},
                      Arm{SINGLE, SCHEDULE_BLOCKS, CRITIC_HEADS_SHARED}));

TEST(MinibatchStepTest, TheReportedLossesAddUpToTheIndependentLoss) {
  const RunConfig config = SmallConfig();
  network::WorkerTeam team(2);
  Prepared prepared = Prepare(config, team);
  const std::vector<double> at(prepared.state.parameters.begin(), prepared.state.parameters.end());
  MinibatchStep step(config, team);
  step.Begin(prepared.state);
  const MinibatchSums sums =
      step.Run(prepared.batch, prepared.samples, {1e-3, 0.03}, prepared.state);
  const double n = double(prepared.samples.size());
  EXPECT_NEAR((sums.policy_loss - 0.03 * sums.entropy + 0.5 * sums.value_loss) / n,
              Loss(config, prepared.batch, prepared.samples, at, 0.03), 1e-5);
}

TEST(MinibatchStepTest, AStepIsAdamOnTheClippedGradient) {
  RunConfig config = SmallConfig();
  config.mutable_ppo()->set_max_gradient_norm(0.01);
  network::WorkerTeam team(1);
  Prepared prepared = Prepare(config, team);
  const std::vector<float> before = prepared.state.parameters;
  MinibatchStep step(config, team);
  step.Begin(prepared.state);
  const MinibatchSums sums = step.Run(prepared.batch, prepared.samples, {1e-3, 0}, prepared.state);
  ASSERT_GT(sums.gradient_norm, 0.02);
  for (std::size_t i = 0; i < before.size(); ++i) {
    // Adam's first step moves by rate * g / (|g| + epsilon).
    const double g = step.gradient()[i] * 0.01 / sums.gradient_norm;
    EXPECT_NEAR(prepared.state.parameters[i], before[i] - 1e-3 * g / (std::abs(g) + 1e-5), 1e-6);
  }
  EXPECT_EQ(prepared.state.adam_steps, 1U);
}

// The passes read packed copies of the parameters, which each step has to renew.
TEST(MinibatchStepTest, AStepGoesOnFromAllThatTheOneBeforeChanged) {
  RunConfig config = SmallConfig();
  config.mutable_ppo()->set_shared_heads(true);
  config.mutable_ppo()->set_min_std(0.61);
  network::WorkerTeam team(2);
  Prepared prepared = Prepare(config, team);
  MinibatchStep one(config, team);
  one.Begin(prepared.state);
  one.Run(prepared.batch, prepared.samples, {1e-2, 0}, prepared.state);
  OptimiserState begun_anew = prepared.state;
  MinibatchStep other(config, team);
  other.Begin(begun_anew);
  other.Run(prepared.batch, prepared.samples, {1e-2, 0}, begun_anew);
  one.Run(prepared.batch, prepared.samples, {1e-2, 0}, prepared.state);
  EXPECT_EQ(one.gradient(), other.gradient());
  EXPECT_EQ(prepared.state.parameters, begun_anew.parameters);
}

TEST(MinibatchStepTest, ANonFiniteSampleIsNamedAndLeavesTheStateAlone) {
  const RunConfig config = SmallConfig();
  network::WorkerTeam team(1);
  Prepared prepared = Prepare(config, team);
  prepared.batch.rewards[0].target[prepared.samples[3]] = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> before = prepared.state.parameters;
  MinibatchStep step(config, team);
  step.Begin(prepared.state);
  EXPECT_THROW(step.Run(prepared.batch, prepared.samples, {1e-3, 0}, prepared.state),
               algorithm::NonFiniteUpdate);
  EXPECT_EQ(prepared.state.parameters, before);
}

}  // namespace
}  // namespace metronome::ppo
