/// Episodes that end before the horizon: what may come, what they are worth, how they are counted.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "learner/algorithm/episode_check.h"
#include "learner/ppo/trainer.h"
#include "learner/ppo/training_batch.h"
#include "tests/unit/support/environments.h"
#include "tests/unit/support/synthetic_run.h"

namespace metronome::ppo {
namespace {

using testing::SmallConfig;

/// `episode` as the environment would have ended it after `length` steps.
Episode Cut(Episode episode, std::size_t length, StepFlag end) {
  episode.observation.resize((length + 1) * test::kObservationSize);
  episode.action.resize(length * test::kActionSize);
  episode.log_prob.resize(length);
  episode.reward.resize(length);
  episode.head.resize(length);
  episode.flags.resize(length);
  episode.flags.back() = std::uint8_t((episode.flags.back() & kStepSuccess) | end);
  return episode;
}

RunConfig EarlyConfig() {
  RunConfig config = SmallConfig();
  config.mutable_environment()->mutable_spec()->set_may_end_early(true);
  return config;
}

class EarlyEndCheckTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::string Verdict(const Episode& episode) const {
    policy::Policy policy(config_, snapshot_);
    return algorithm::CheckEpisode(episode, policy, config_, 99).value_or("accepted");
  }

  RunConfig config_ = EarlyConfig();
  const PolicySnapshot snapshot_ = SnapshotOf(Trainer::InitialState(config_), config_);
  const Episode whole_ = testing::SyntheticEpisode(config_, snapshot_, 6);
};

TEST_F(EarlyEndCheckTest, AnEpisodeMayEndAtAnyStepForOneReason) {
  EXPECT_EQ(Verdict(whole_), "accepted");
  for (const std::size_t length : {1U, 4U, 39U}) {
    EXPECT_EQ(Verdict(Cut(whole_, length, kStepTerminated)), "accepted") << length;
    EXPECT_EQ(Verdict(Cut(whole_, length, kStepTruncated)), "accepted") << length;
    EXPECT_NE(Verdict(Cut(whole_, length, StepFlag(kStepTerminated | kStepTruncated))), "accepted");
    EXPECT_NE(Verdict(Cut(whole_, length, StepFlag(0))), "accepted") << "it just ends";
  }
  EXPECT_EQ(Verdict(Cut(whole_, 40, kStepTerminated)), "accepted");
  Episode twice = Cut(whole_, 20, kStepTerminated);
  twice.flags[7] |= kStepTruncated;
  EXPECT_EQ(Verdict(twice), "step 7 has flags 4");
}

TEST_F(EarlyEndCheckTest, ALogProbabilityIsCheckedInShortEpisodesToo) {
  for (const std::size_t length : {1U, 6U}) {
    Episode wrong = Cut(whole_, length, kStepTerminated);
    wrong.log_prob.back() += 0.01F;
    EXPECT_NE(Verdict(wrong).find("log-probability"), std::string::npos) << length;
  }
}

TEST_F(EarlyEndCheckTest, LengthsAreTheEnvironments) {
  Episode none = whole_;
  none.reward.clear();
  EXPECT_EQ(Verdict(none), "it has 0 steps, not 1 to 40");
  Episode longer = whole_;
  longer.reward.push_back(0);
  EXPECT_EQ(Verdict(longer), "it has 41 steps, not 1 to 40");
  config_.mutable_environment()->mutable_spec()->set_may_end_early(false);
  EXPECT_EQ(Verdict(Cut(whole_, 20, kStepTruncated)), "it has 20 steps, not 40");
  EXPECT_EQ(Verdict(Cut(whole_, 40, kStepTerminated)), "step 39 has flags 2");
}

TEST_F(EarlyEndCheckTest, WhatHasNoSuccessReportsNone) {
  config_.mutable_environment()->mutable_spec()->set_has_success(false);
  EXPECT_EQ(Verdict(whole_), "step 5 has flags 1");
}

/// Four steps at most, rewards of 1, discount and lambda 1/2, and a critic that gives 1 while head
/// 0 acts (steps 0 and 1) and 2 while head 1 does: all numbers below are made by hand.
class HandMadeBatchTest : public ::testing::Test {
 protected:
  HandMadeBatchTest() {
    EnvironmentSpec& spec = *config_.mutable_environment()->mutable_spec();
    spec.set_observation_size(2);
    spec.set_action_size(1);
    config_.mutable_environment()->set_horizon(4);
    config_.mutable_policy()->set_heads(2);
    config_.mutable_policy()->clear_hidden();
    config_.mutable_policy()->add_hidden(1);
    config_.mutable_ppo()->set_discount(0.5);
    config_.mutable_ppo()->set_gae_lambda(0.5);
    const policy::NetworkShape shape = policy::ShapeOf(config_);
    parameters_.assign(policy::ParameterCount(shape), 0.0F);
    float* bias = parameters_.data() + policy::ActorLayout(shape).size +
                  policy::CriticLayout(shape).head.bias;
    bias[0] = 1;
    bias[1] = 2;
    behaviour_.parameters.assign(policy::ActorLayout(shape).size, 0.0F);
    behaviour_.observation_mean.assign(2, 0.0F);
    behaviour_.observation_inv_std.assign(2, 1.0F);
  }

  void Add(std::size_t length, StepFlag end) {
    Episode episode;
    episode.number = episodes_.size();
    const auto mark = float(episodes_.size());
    for (std::size_t t = 0; t <= length; ++t) {
      episode.observation.insert(episode.observation.end(), {mark, float(t)});
    }
    for (std::size_t t = 0; t < length; ++t) {
      episode.action.push_back(10 * mark + float(t));
      episode.log_prob.push_back(-1);
      episode.reward.push_back(1);
      episode.head.push_back(std::uint16_t(t / 2));
      episode.flags.push_back(t + 1 == length ? end : 0);
    }
    episodes_.push_back(std::move(episode));
  }

  TrainingBatch Build() {
    network::WorkerTeam team(2);
    return BuildBatch({config_, episodes_, 0, behaviour_, parameters_.data(), {1}}, team);
  }

  RunConfig config_ = EarlyConfig();
  std::vector<float> parameters_;
  PolicySnapshot behaviour_;
  std::vector<Episode> episodes_;
};

TEST_F(HandMadeBatchTest, WhatFollowsTheLastStepDependsOnWhyItIsTheLast) {
  Add(2, kStepTerminated);  // nothing
  Add(2, kStepTruncated);   // the value of state 2, which head 1 would have acted in
  Add(4, kStepTruncated);   // the horizon: nothing
  const TrainingBatch batch = Build();
  EXPECT_EQ(batch.size(), 8U);
  EXPECT_EQ(batch.rewards[0].value, (std::vector<float>{1, 1, 1, 1, 1, 1, 2, 2}));
  EXPECT_EQ(batch.advantage, (std::vector<float>{0.5, 0, 0.75, 1, 0.734375, 0.9375, -0.25, -1}));
  EXPECT_EQ(batch.rewards[0].target,
            (std::vector<float>{1.5, 1, 1.75, 2, 1.734375, 1.9375, 1.75, 1}));
}

TEST_F(HandMadeBatchTest, AtTheHorizonTheSettingDecidesUnlessTheEpisodeIsTerminated) {
  config_.mutable_ppo()->set_time_limit_value(BOOTSTRAP);
  Add(4, kStepTruncated);
  Add(4, kStepTerminated);
  const TrainingBatch batch = Build();
  EXPECT_EQ(batch.advantage, (std::vector<float>{0.75, 1, 0, 0, 0.734375, 0.9375, -0.25, -1}));
}

TEST_F(HandMadeBatchTest, EachSampleIsItsStep) {
  Add(1, kStepTerminated);
  Add(3, kStepTruncated);
  Add(2, kStepTruncated);
  const TrainingBatch batch = Build();
  EXPECT_EQ(batch.head, (std::vector<std::uint16_t>{0, 0, 0, 1, 0, 0}));
  std::vector<float> actions;
  std::vector<float> input;
  for (std::size_t i = 0; i < batch.size(); ++i) {
    actions.push_back(batch.action.row(i)[0]);
    input.insert(input.end(), batch.input.row(i), batch.input.row(i) + batch.input.columns());
  }
  EXPECT_EQ(actions, (std::vector<float>{0, 10, 11, 12, 20, 21}));
  EXPECT_EQ(input, (std::vector<float>{0, 0, 1, 0, 1, 1, 1, 2, 2, 0, 2, 1}));
}

std::vector<Episode> ShortBatch(const RunConfig& config, const PpoState& state) {
  std::vector<Episode> episodes =
      testing::SyntheticBatch(config, SnapshotOf(state, config), state.version);
  for (std::size_t i = 0; i < episodes.size(); ++i) {
    episodes[i] = Cut(episodes[i], 1 + i, i % 2 == 0 ? kStepTerminated : kStepTruncated);
  }
  return episodes;  // 1 + 2 + ... + 10 steps
}

TEST(EarlyEndTrainerTest, CountsTheStepsThatWereTakenAndTheRateFollowsThem) {
  RunConfig config = EarlyConfig();
  config.set_total_steps(110);
  Trainer trainer(config, Trainer::InitialState(config), 2);
  EXPECT_EQ(trainer.Update(ShortBatch(config, trainer.state())).steps, 55U);
  EXPECT_EQ(trainer.state().observation[0].count, 55);
  const PpoReport second = trainer.Update(ShortBatch(config, trainer.state()));
  EXPECT_EQ(second.steps, 110U);
  EXPECT_EQ(second.episodes_used, 20U);
  EXPECT_DOUBLE_EQ(second.learning_rate, 2.5e-4);
}

TEST(EarlyEndTrainerTest, AMinibatchLargerThanTheBatchIsTheBatch) {
  RunConfig config = EarlyConfig();  // minibatches of 150
  Trainer large(config, Trainer::InitialState(config), 1);
  const std::vector<Episode> batch = ShortBatch(config, large.state());
  large.Update(batch);
  config.mutable_ppo()->set_minibatch(55);
  Trainer exact(config, Trainer::InitialState(config), 3);
  exact.Update(batch);
  EXPECT_EQ(large.state(), exact.state());
}

}  // namespace
}  // namespace metronome::ppo
