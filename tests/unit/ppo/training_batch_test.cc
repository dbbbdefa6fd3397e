#include "learner/ppo/training_batch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>
#include <vector>

#include "learner/ppo/gae.h"
#include "learner/ppo/trainer.h"
#include "tests/unit/support/double_network.h"
#include "tests/unit/support/environments.h"
#include "tests/unit/support/synthetic_run.h"

namespace metronome::ppo {
namespace {

using testing::Forward;
using testing::SmallConfig;
using testing::SyntheticBatch;

constexpr int kHorizon = 40;
constexpr float kScale = 0.7F;

/// Schedule and critic of a run whose weights are far from their start, so that heads differ.
class TrainingBatchTest : public ::testing::TestWithParam<std::tuple<Schedule, CriticHeads, int>> {
 protected:
  TrainingBatchTest() : config_(SmallConfig(MULTIHEAD, 3, std::get<2>(GetParam()))) {
    config_.mutable_policy()->set_schedule(std::get<0>(GetParam()));
    config_.mutable_policy()->set_critic_heads(std::get<1>(GetParam()));
    config_.mutable_policy()->set_critic_time(CriticSeesTime());
    config_.mutable_ppo()->set_time_limit_value(BOOTSTRAP);
    state_ = Trainer::InitialState(config_);
    behaviour_ = SnapshotOf(state_, config_);
    episodes_ = SyntheticBatch(config_, behaviour_, 1);  // numbers 10..19
    numbers::RandomStream random(numbers::RandomPurpose::kEvaluate, 8, 8, 8);
    for (float& parameter : state_.parameters) parameter += 0.1F * float(random.Normal());
    network::WorkerTeam team(1);
    batch_ =
        BuildBatch({config_, episodes_, 0, behaviour_, state_.parameters.data(), {kScale}}, team);
  }

  /// With heads of its own, so that both occur.
  static bool CriticSeesTime() { return std::get<1>(GetParam()) == CRITIC_HEADS_SEPARATE; }

  /// By definition: blocks, turns, or blocks by the permutation of the episode's number.
  [[nodiscard]] int HeadAt(std::size_t episode, int t) const {
    const int block = t * 3 / kHorizon;
    if (std::get<0>(GetParam()) == SCHEDULE_BLOCKS) return block;
    if (std::get<0>(GetParam()) == SCHEDULE_INTERLEAVED) return t % 3;
    return int(numbers::Permutation(
        3, {numbers::RandomPurpose::kHeadPermutation, 5, 10 + episode, 1})[std::size_t(block)]);
  }

  /// Input of the policy: version 0 has no statistics, observations are far from the clip.
  [[nodiscard]] std::vector<double> InputAt(std::size_t episode, int t) const {
    const auto row = episodes_[episode].observation.begin() + t * test::kObservationSize;
    std::vector<double> input(row, row + test::kObservationSize);
    for (double& x : input) x = std::fmax(-10, std::fmin(10, x));
    return input;
  }

  [[nodiscard]] double ValueOf(std::size_t episode, int t, int head) const {
    const std::size_t actor = policy::ActorLayout(policy::ShapeOf(config_)).size;
    const std::vector<float> critic(state_.parameters.begin() + std::ptrdiff_t(actor),
                                    state_.parameters.end());
    const bool shared = std::get<1>(GetParam()) == CRITIC_HEADS_SHARED;
    std::vector<double> input = InputAt(episode, t);
    if (CriticSeesTime()) input.push_back(2.0 * t / kHorizon - 1);
    return Forward(critic, policy::CriticLayout(policy::ShapeOf(config_)), input,
                   shared ? 0 : head)[0];
  }

  RunConfig config_;
  PpoState state_;
  PolicySnapshot behaviour_;
  std::vector<Episode> episodes_;
  TrainingBatch batch_;
};

TEST_P(TrainingBatchTest, EachStateIsValuedByItsHeadAndTheFinalOneByTheLastStepsHead) {
  for (std::size_t episode = 0; episode < 10; ++episode) {
    const std::size_t begin = episode * kHorizon;
    for (int t = 0; t < kHorizon; ++t) {
      ASSERT_NEAR(batch_.rewards[0].value[begin + std::size_t(t)],
                  ValueOf(episode, t, HeadAt(episode, t)), 2e-5)
          << "episode " << episode << ", step " << t;
    }
    // Of the last step: target = reward + discount * V(s_T), whatever lambda.
    const double final_value = ValueOf(episode, kHorizon, HeadAt(episode, kHorizon - 1));
    ASSERT_NEAR(batch_.rewards[0].target[begin + kHorizon - 1],
                episodes_[episode].reward.back() / kScale + 0.99 * final_value, 5e-5);
  }
}

TEST_P(TrainingBatchTest, TheProximalPolicyIsTheSameHeads) {
  const policy::MlpLayout actor = policy::ActorLayout(policy::ShapeOf(config_));
  for (std::size_t episode = 0; episode < 10; ++episode) {
    for (int t = 0; t < kHorizon; ++t) {
      const std::size_t sample = episode * kHorizon + std::size_t(t);
      ASSERT_EQ(batch_.head[sample], HeadAt(episode, t));
      if (std::get<2>(GetParam()) == 0) {
        ASSERT_EQ(batch_.proximal_log_prob[sample], episodes_[episode].log_prob[std::size_t(t)]);
        continue;
      }
      const int head = HeadAt(episode, t);
      const auto mean = Forward(state_.parameters, actor, InputAt(episode, t), head);
      double want = 0;
      for (std::size_t i = 0; i < 4; ++i) {
        const double log_std = state_.parameters[actor.log_std + std::size_t(head) * 4 + i];
        const double z =
            (episodes_[episode].action[std::size_t(t) * 4 + i] - mean[i]) / std::exp(log_std);
        want += -0.5 * z * z - log_std - 0.5 * std::log(2 * M_PI);
      }
      ASSERT_NEAR(batch_.proximal_log_prob[sample], want, 1e-4 * (1 + std::abs(want)));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Arms, TrainingBatchTest,
    ::testing::Combine(::testing::Values(SCHEDULE_BLOCKS, SCHEDULE_INTERLEAVED, SCHEDULE_SHUFFLED),
                       ::testing::Values(CRITIC_HEADS_SEPARATE, CRITIC_HEADS_SHARED),
                       ::testing::Values(0, 1)));

/// Ten episodes of three heads, with success in step 5 of numbers 0, 3, 6, 9, and weights that have
/// moved since they were played.
class RewardPartsTest : public ::testing::Test {
 protected:
  RewardPartsTest() {
    config_.mutable_environment()->set_reward(REWARD_SUCCESS);
    config_.mutable_ppo()->set_success_weight(2);
    state_ = Trainer::InitialState(config_);
    behaviour_ = SnapshotOf(state_, config_);
    episodes_ = SyntheticBatch(config_, behaviour_, 0);
    numbers::RandomStream random(numbers::RandomPurpose::kEvaluate, 8, 8, 8);
    for (float& parameter : state_.parameters) parameter += 0.2F * float(random.Normal());
  }

  TrainingBatch Build(std::size_t earlier = 0) {
    network::WorkerTeam team(2);
    return BuildBatch(
        {config_, episodes_, earlier, behaviour_, state_.parameters.data(), {kScale, 0.1F}}, team);
  }

  RunConfig config_ = SmallConfig();
  PpoState state_;
  PolicySnapshot behaviour_;
  std::vector<Episode> episodes_;
};

TEST_F(RewardPartsTest, AreTheOfficialRewardAndOneAStepWithSuccess) {
  const auto parts = RewardParts(episodes_[3], config_);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0], episodes_[3].reward);
  for (std::size_t t = 0; t < kHorizon; ++t) EXPECT_EQ(parts[1][t], t == 5 ? 1 : 0);
  config_.mutable_ppo()->set_success_weight(0);
  const auto together = RewardParts(episodes_[3], config_);
  ASSERT_EQ(together.size(), 1U);
  EXPECT_EQ(together[0][5], episodes_[3].reward[5] + 25);
  config_.mutable_ppo()->set_success_weight(2);
  config_.mutable_environment()->set_reward(REWARD_OFFICIAL);
  EXPECT_EQ(RewardParts(episodes_[3], config_).size(), 1U);
}

TEST_F(RewardPartsTest, EachIsValuedByAnOutputOfItsOwnAndAScaleOfItsOwn) {
  const TrainingBatch batch = Build();
  ASSERT_EQ(batch.rewards.size(), 2U);
  const policy::MlpLayout critic = policy::CriticLayout(policy::ShapeOf(config_));
  const std::vector<float> weights(
      state_.parameters.begin() +
          std::ptrdiff_t(policy::ActorLayout(policy::ShapeOf(config_)).size),
      state_.parameters.end());
  const float scales[] = {kScale, 0.1F};
  const auto parts = RewardParts(episodes_[3], config_);
  for (std::size_t part = 0; part < 2; ++part) {
    std::vector<float> rewards = parts[part];
    std::vector<float> values;
    for (std::size_t t = 0; t < kHorizon; ++t) {
      rewards[t] /= scales[part];
      const auto row = batch.input.row(3 * kHorizon + t);
      const std::vector<double> input(row, row + test::kObservationSize);
      values.push_back(float(Forward(weights, critic, input, int(t) * 3 / kHorizon)[part]));
      ASSERT_NEAR(batch.rewards[part].value[3 * kHorizon + t], values[t], 2e-5);
    }
    const GaeResult gae = ComputeGae(rewards, values, 0, {0.99, 0.95});
    for (std::size_t t = 0; t < kHorizon; ++t) {
      ASSERT_NEAR(batch.rewards[part].target[3 * kHorizon + t], gae.target[t], 2e-4);
    }
  }
}

TEST_F(RewardPartsTest, AdvantagesAddUpTheOfficialOneOfSizeOneAndTheWeightTimesThatOfSuccess) {
  const TrainingBatch batch = Build();
  double squares = 0;
  for (const float advantage : batch.rewards[0].advantage) squares += double{advantage} * advantage;
  const double rms = std::sqrt(squares / double(batch.size()));
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const double want = batch.rewards[0].advantage[i] / rms + 2 * batch.rewards[1].advantage[i];
    ASSERT_NEAR(batch.advantage[i], want, 1e-4 * (1 + std::abs(want)));
  }
}

TEST_F(RewardPartsTest, EpisodesOfEarlierBatchesCountByTodaysPolicyButTwiceAtMost) {
  const TrainingBatch batch = Build(4);
  int cut = 0;
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const float given = episodes_[i / kHorizon].log_prob[i % kHorizon];
    if (i >= 4 * kHorizon) {  // of the batch itself
      ASSERT_EQ(batch.proximal_log_prob[i], given);
      ASSERT_EQ(batch.behaviour_weight[i], 1);
      continue;
    }
    ASSERT_NE(batch.proximal_log_prob[i], given);
    const double weight = std::exp(double{batch.proximal_log_prob[i]} - given);
    ASSERT_NEAR(batch.behaviour_weight[i], std::fmin(weight, 2), 1e-5 * weight);
    cut += weight > 2 ? 1 : 0;
  }
  EXPECT_GT(cut, 0);
}

}  // namespace
}  // namespace metronome::ppo
