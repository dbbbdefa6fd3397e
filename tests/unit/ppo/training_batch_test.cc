#include "learner/ppo/training_batch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>
#include <vector>

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
    batch_ = BuildBatch({config_, episodes_, behaviour_, state_.parameters.data(), {kScale}}, team);
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
      ASSERT_NEAR(batch_.value[begin + std::size_t(t)], ValueOf(episode, t, HeadAt(episode, t)),
                  2e-5)
          << "episode " << episode << ", step " << t;
    }
    // Of the last step: target = reward + discount * V(s_T), whatever lambda.
    const double final_value = ValueOf(episode, kHorizon, HeadAt(episode, kHorizon - 1));
    ASSERT_NEAR(batch_.target[begin + kHorizon - 1],
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

}  // namespace
}  // namespace metronome::ppo
