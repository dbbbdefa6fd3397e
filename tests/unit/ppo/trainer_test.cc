#include "learner/ppo/trainer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "learner/algorithm/algorithm.h"
#include "learner/algorithm/episode_check.h"
#include "learner/network/running_statistics.h"
#include "tests/unit/support/synthetic_run.h"

namespace metronome::ppo {
namespace {

constexpr std::uint64_t kCheckKey = 99;

using testing::SmallConfig;
using testing::SyntheticBatch;

PpoState TrainFor(const RunConfig& config, int updates, int threads) {
  Trainer trainer(config, Trainer::InitialState(config), threads);
  for (int i = 0; i < updates; ++i) {
    const PpoState& state = trainer.state();
    const bool lags = config.collection().overlap() > 0 && state.version > 0;
    const PolicySnapshot snapshot =
        lags ? PreviousSnapshotOf(state, config) : SnapshotOf(state, config);
    trainer.Update(SyntheticBatch(config, snapshot, state.version));
  }
  return trainer.state();
}

class TrainerBitsTest : public ::testing::TestWithParam<std::tuple<int, Schedule, CriticHeads>> {
 protected:
  static int Overlap() { return std::get<0>(GetParam()); }
  static RunConfig Config() {
    RunConfig config = SmallConfig(MULTIHEAD, 3, Overlap());
    config.mutable_policy()->set_schedule(std::get<1>(GetParam()));
    config.mutable_policy()->set_critic_heads(std::get<2>(GetParam()));
    return config;
  }
};

TEST_P(TrainerBitsTest, AnyNumberOfThreadsGivesTheSameState) {
  const RunConfig config = Config();
  const PpoState one = TrainFor(config, 3, 1);
  EXPECT_EQ(TrainFor(config, 3, 2), one);
  EXPECT_EQ(TrainFor(config, 3, 5), one);
}

TEST_P(TrainerBitsTest, ARestoredStateGoesOnAsIfNothingHadHappened) {
  const RunConfig config = Config();
  const PpoState half = TrainFor(config, 2, 2);
  Trainer resumed(config, half, 2);
  const PolicySnapshot snapshot =
      Overlap() > 0 ? PreviousSnapshotOf(half, config) : SnapshotOf(half, config);
  resumed.Update(SyntheticBatch(config, snapshot, 2));
  EXPECT_EQ(resumed.state(), TrainFor(config, 3, 2));
}

INSTANTIATE_TEST_SUITE_P(
    OverlapAndArms, TrainerBitsTest,
    ::testing::Combine(::testing::Values(0, 1),
                       ::testing::Values(SCHEDULE_BLOCKS, SCHEDULE_INTERLEAVED, SCHEDULE_SHUFFLED),
                       ::testing::Values(CRITIC_HEADS_SEPARATE, CRITIC_HEADS_SHARED)));

// Heads that share, a critic that sees the time, a floor of the std.
RunConfig SharingConfig(int overlap) {
  RunConfig config = SmallConfig(MULTIHEAD, 3, overlap);
  config.mutable_policy()->set_critic_time(true);
  config.mutable_ppo()->set_shared_heads(true);
  config.mutable_ppo()->set_min_std(0.6);
  return config;
}

class SharingTrainerTest : public ::testing::TestWithParam<int> {};

TEST_P(SharingTrainerTest, ThreadsAndARestoredStateChangeNoBit) {
  const RunConfig config = SharingConfig(GetParam());
  const PpoState whole = TrainFor(config, 3, 1);
  EXPECT_EQ(TrainFor(config, 3, 5), whole);
  const PpoState half = TrainFor(config, 2, 2);
  Trainer resumed(config, DecodePpoState(EncodePpoState(half, config), config), 2);
  const PolicySnapshot snapshot =
      GetParam() > 0 ? PreviousSnapshotOf(half, config) : SnapshotOf(half, config);
  resumed.Update(SyntheticBatch(config, snapshot, 2));
  EXPECT_EQ(resumed.state(), whole);
}

INSTANTIATE_TEST_SUITE_P(Overlap, SharingTrainerTest, ::testing::Values(0, 1));

TEST(TrainerTest, AStateWithoutWhatHeadsShareIsRefused) {
  const PpoState state = Trainer::InitialState(SmallConfig());
  EXPECT_THROW(Trainer(SharingConfig(0), state, 1), std::invalid_argument);
}

TEST(TrainerTest, HeadsThatShareBeginEqualAndMoveTogetherMost) {
  const RunConfig config = SharingConfig(0);
  const policy::MlpLayout actor = policy::ActorLayout(policy::ShapeOf(config));
  const auto apart = [&](const PpoState& state) {
    const float* bias = state.parameters.data() + actor.head.bias;
    double sum = 0;
    for (int i = 0; i < 4; ++i) sum += std::abs(double{bias[i]} - bias[8 + i]);
    return sum;
  };
  EXPECT_EQ(apart(Trainer::InitialState(config)), 0);
  RunConfig quick = config;
  quick.mutable_ppo()->set_shared_heads_decay(1e9);  // nothing sets a head apart for long
  EXPECT_GT(apart(TrainFor(config, 3, 1)), 0);
  EXPECT_LT(apart(TrainFor(quick, 3, 1)), 1e-6);
}

TEST(TrainerTest, StandardDeviationsStayAtTheirFloor) {
  RunConfig config = SmallConfig();
  config.mutable_ppo()->set_entropy_coefficient(0);
  config.mutable_ppo()->set_min_std(0.606);  // just below the first, exp(-0.5)
  const PpoState floored = TrainFor(config, 6, 1);
  config.mutable_ppo()->set_min_std(0);
  const PpoState free = TrainFor(config, 6, 1);
  const policy::MlpLayout actor = policy::ActorLayout(policy::ShapeOf(config));
  const auto least = [&](const PpoState& state) {
    return *std::min_element(state.parameters.begin() + std::ptrdiff_t(actor.log_std),
                             state.parameters.begin() + std::ptrdiff_t(actor.size));
  };
  EXPECT_LT(least(free), std::log(0.606F));
  EXPECT_EQ(least(floored), float(std::log(0.606)));
}

// Of four updates of one batch each, half are in the decay: before them 0 and 1/2 of it are over.
TEST(TrainerTest, StandardDeviationsAreLoweredToTheirFloor) {
  RunConfig config = SmallConfig();
  config.mutable_policy()->set_initial_log_std(0);
  config.mutable_ppo()->set_entropy_coefficient(10);  // upwards
  config.mutable_ppo()->set_min_std(0.25);
  config.mutable_ppo()->set_std_decay(0.5);
  const std::uint64_t batch = TrainFor(config, 1, 1).steps;
  config.set_total_steps(4 * batch);
  const policy::MlpLayout actor = policy::ActorLayout(policy::ShapeOf(config));
  const std::vector<float> bounds = {0, std::log(0.5F), std::log(0.25F), std::log(0.25F)};
  for (int updates = 1; updates <= 4; ++updates) {
    const PpoState state = TrainFor(config, updates, 1);
    for (std::size_t i = actor.log_std; i < actor.size; ++i) {
      EXPECT_NEAR(state.parameters[i], bounds[std::size_t(updates - 1)], 1e-6) << updates;
    }
  }
}

// Adam's first step is the rate, but for its epsilon.
TEST(TrainerTest, LogStdsLearnByARateOfTheirOwn) {
  RunConfig config = SmallConfig();
  config.mutable_ppo()->set_epochs(1);
  config.mutable_ppo()->set_minibatch(config.collection().episodes_per_update() *
                                      config.environment().horizon());
  config.mutable_ppo()->set_entropy_coefficient(10);  // all the same way
  config.mutable_ppo()->set_entropy_coefficient_final(10);
  config.mutable_ppo()->set_max_gradient_norm(1e9);
  const PpoState same = TrainFor(config, 1, 1);
  config.mutable_ppo()->set_log_std_rate(10);
  const PpoState faster = TrainFor(config, 1, 1);
  const policy::MlpLayout actor = policy::ActorLayout(policy::ShapeOf(config));
  const auto first = float(config.policy().initial_log_std());
  const auto rate = float(config.ppo().learning_rate());
  for (std::size_t i = 0; i < same.parameters.size(); ++i) {
    if (i < actor.log_std || i >= actor.size) {
      ASSERT_EQ(faster.parameters[i], same.parameters[i]) << i;
    } else {
      EXPECT_NEAR(same.parameters[i] - first, rate, 1e-3 * rate) << i;
      EXPECT_NEAR(faster.parameters[i] - first, 10 * rate, 1e-2 * rate) << i;
    }
  }
}

// Without decay each batch, equally long, counts as much as the one before it.
TEST(TrainerTest, TheScaleOfRewardsForgetsEarlierBatches) {
  RunConfig config = SmallConfig();
  const double batch = TrainFor(config, 1, 1).reward_return[0].count;
  EXPECT_EQ(TrainFor(config, 3, 1).reward_return[0].count, 3 * batch);
  config.mutable_ppo()->set_reward_scale_decay(0.5);
  EXPECT_EQ(TrainFor(config, 3, 1).reward_return[0].count, 1.75 * batch);
}

std::vector<std::uint64_t> NumbersOf(const std::vector<Episode>& episodes) {
  std::vector<std::uint64_t> numbers;
  for (const Episode& episode : episodes) numbers.push_back(episode.number);
  return numbers;
}

TEST(TrainerTest, LearnsFromEarlierBatchesTooAndGoesOnFromAStateWithThem) {
  RunConfig config = SmallConfig();
  config.mutable_ppo()->set_earlier_batches(2);
  EXPECT_EQ(TrainFor(config, 1, 1).parameters, TrainFor(SmallConfig(), 1, 1).parameters);
  EXPECT_NE(TrainFor(config, 2, 1).parameters, TrainFor(SmallConfig(), 2, 1).parameters);
  const PpoState state = TrainFor(config, 4, 1);
  std::vector<std::uint64_t> latest(20);
  std::iota(latest.begin(), latest.end(), 20U);  // of batches of ten
  EXPECT_EQ(NumbersOf(state.earlier), latest);
  EXPECT_EQ(state, TrainFor(config, 4, 3));
  Trainer resumed(config, DecodePpoState(EncodePpoState(TrainFor(config, 3, 1), config), config),
                  1);
  resumed.Update(SyntheticBatch(config, SnapshotOf(resumed.state(), config), 3));
  EXPECT_EQ(resumed.state(), state);
}

// As a ratio of the batch's own such a log-probability would be infinite.
TEST(TrainerTest, WhatEarlierEpisodesSayOfTheirPolicyIsAWeightThatIsCutOff) {
  RunConfig config = SmallConfig();
  config.mutable_ppo()->set_earlier_batches(1);
  PpoState state = TrainFor(config, 1, 1);
  for (Episode& episode : state.earlier) episode.log_prob.assign(40, -100.0F);
  Trainer trainer(config, state, 1);
  EXPECT_NO_THROW(trainer.Update(SyntheticBatch(config, SnapshotOf(state, config), 1)));
}

TEST(TrainerTest, EachPartOfTheRewardHasAScaleOfItsOwn) {
  RunConfig config = SmallConfig();
  config.mutable_environment()->set_reward(REWARD_SUCCESS);
  config.mutable_ppo()->set_success_weight(2);
  const PpoState state = TrainFor(config, 1, 1);
  ASSERT_EQ(state.reward_return[0].mean.size(), 2U);
  EXPECT_EQ(state.reward_return[0].mean[0], TrainFor(SmallConfig(), 1, 1).reward_return[0].mean[0]);
  // Four episodes of ten have one success, in step 5 of 40: a sum of discount^0 .. discount^34.
  EXPECT_NEAR(state.reward_return[0].mean[1], 0.4 * (1 - std::pow(0.99, 35)) / 0.01 / 40, 1e-6);
}

TEST(TrainerTest, LearnsWhatTheRewardAsksFor) {
  RunConfig config = SmallConfig();
  config.set_total_steps(40 * 400);
  config.mutable_ppo()->set_learning_rate(3e-3);
  config.mutable_ppo()->set_entropy_coefficient(0);
  config.mutable_ppo()->set_discount(0);  // each reward is its own action's doing
  Trainer trainer(config, Trainer::InitialState(config), 2);
  std::vector<double> returns;
  for (int i = 0; i < 40; ++i) {
    const PolicySnapshot snapshot = SnapshotOf(trainer.state(), config);
    returns.push_back(
        trainer.Update(SyntheticBatch(config, snapshot, trainer.state().version)).mean_return);
  }
  // 1 / (1 + |a|^2) over 40 steps: the only way up is to act less and spread less.
  EXPECT_GT(returns.back(), returns.front() + 5);
}

TEST(TrainerTest, LearnsFromTheRewardOfSuccessAndReportsWithoutIt) {
  const RunConfig config = SmallConfig();
  RunConfig rewarded = config;
  rewarded.mutable_environment()->set_reward(REWARD_SUCCESS);
  rewarded.mutable_environment()->set_success_reward(10);  // one value, of the sum
  Trainer by_setting(rewarded, Trainer::InitialState(rewarded), 1);
  Trainer by_hand(config, Trainer::InitialState(config), 1);
  std::vector<Episode> episodes = SyntheticBatch(config, SnapshotOf(by_hand.state(), config), 0);
  const PpoReport report = by_setting.Update(episodes);
  const double official =
      Trainer(config, Trainer::InitialState(config), 1).Update(episodes).mean_return;
  for (const int number : {0, 3, 6, 9}) episodes[std::size_t(number)].reward[5] += 10;
  const PpoReport report_by_hand = by_hand.Update(episodes);
  EXPECT_EQ(by_setting.state(), by_hand.state());
  EXPECT_DOUBLE_EQ(report.reward_scale, report_by_hand.reward_scale);
  EXPECT_DOUBLE_EQ(report.mean_return, official);
  EXPECT_NEAR(report_by_hand.mean_return, official + 4, 1e-5);
}

TEST(TrainerTest, CountsVersionsStepsAndEpisodes) {
  const RunConfig config = SmallConfig();
  Trainer trainer(config, Trainer::InitialState(config), 1);
  const PolicySnapshot snapshot = SnapshotOf(trainer.state(), config);
  const PpoReport report = trainer.Update(SyntheticBatch(config, snapshot, 0));
  EXPECT_EQ(report.version, 1U);
  EXPECT_EQ(report.steps, 400U);
  EXPECT_EQ(report.episodes_used, 10U);
  EXPECT_DOUBLE_EQ(report.success, 0.4);  // episodes 0, 3, 6, 9
  EXPECT_DOUBLE_EQ(report.success_end, 0);
  EXPECT_DOUBLE_EQ(report.learning_rate, 5e-4);
  EXPECT_EQ(report.epochs, 3);
  EXPECT_EQ(report.head_kl.size(), 3U);
  EXPECT_EQ(trainer.state().observation[0].count, 400);
}

TEST(TrainerTest, EachOfSeveralTasksHasStatisticsAndFiguresOfItsOwn) {
  RunConfig config = SmallConfig();
  for (const char* task : {"one", "two"})
    config.mutable_environment()->mutable_spec()->add_tasks(task);
  Trainer trainer(config, Trainer::InitialState(config), 1);
  std::vector<Episode> batch = SyntheticBatch(config, SnapshotOf(trainer.state(), config), 0);
  for (std::size_t i = 1; i < batch.size(); i += 2) {  // of the second
    for (float& reward : batch[i].reward) reward *= 100;
    for (std::size_t t = 0; t <= 40; ++t) batch[i].observation[t * 39] += 7;
  }
  const PpoReport report = trainer.Update(batch);
  ASSERT_EQ(report.tasks.size(), 2U);
  EXPECT_EQ(report.tasks[1].name, "two");
  EXPECT_GT(report.tasks[1].mean_return, 50 * report.tasks[0].mean_return);
  EXPECT_NEAR(report.mean_return, (report.tasks[0].mean_return + report.tasks[1].mean_return) / 2,
              1e-9);
  EXPECT_DOUBLE_EQ(report.tasks[0].success, 0.4);  // episodes 0 and 6 of 0, 2, 4, 6, 8
  const PpoState& state = trainer.state();
  ASSERT_EQ(state.observation.size(), 2U);
  EXPECT_EQ(state.observation[0].count, 200);
  EXPECT_NEAR(state.observation[1].mean[0] - state.observation[0].mean[0], 7, 0.5);
  const auto scale = [&state](std::size_t task) {
    return network::StandardDeviation(state.reward_return[task], 0);
  };
  EXPECT_GT(scale(1), 50 * scale(0));
  EXPECT_NEAR(report.reward_scale, (scale(0) + scale(1)) / 2, 1e-3);
  EXPECT_EQ(DecodePpoState(EncodePpoState(state, config), config), state);
}

TEST(TrainerTest, TheLearningRateFallsLinearlyToItsFloor) {
  RunConfig config = SmallConfig();
  config.set_total_steps(800);
  Trainer trainer(config, Trainer::InitialState(config), 1);
  std::vector<double> rates;
  for (std::uint64_t i = 0; i < 3; ++i) {
    const PolicySnapshot snapshot = SnapshotOf(trainer.state(), config);
    rates.push_back(trainer.Update(SyntheticBatch(config, snapshot, i)).learning_rate);
  }
  EXPECT_DOUBLE_EQ(rates[0], 5e-4);
  EXPECT_DOUBLE_EQ(rates[1], 2.5e-4);
  EXPECT_DOUBLE_EQ(rates[2], 5e-5);
}

TEST(TrainerTest, NoFurtherEpochOnceTheDivergencePassesTheStop) {
  RunConfig config = SmallConfig();
  config.mutable_ppo()->set_learning_rate(3e-2);
  config.mutable_ppo()->set_epochs(10);
  config.mutable_ppo()->set_kl_stop(0.03);
  Trainer trainer(config, Trainer::InitialState(config), 1);
  const PolicySnapshot snapshot = SnapshotOf(trainer.state(), config);
  const PpoReport report = trainer.Update(SyntheticBatch(config, snapshot, 0));
  EXPECT_LT(report.epochs, 10);
  EXPECT_GT(report.kl, 0.03);
}

/// Minibatches of 150, 150 and 100 samples: the last one is small, and its estimate noisy.
RunConfig StoppingAt(double kl_stop, KlEstimate estimate) {
  RunConfig config = SmallConfig();
  config.mutable_ppo()->set_learning_rate(1e-2);
  config.mutable_ppo()->set_epochs(10);
  config.mutable_ppo()->set_kl_stop(kl_stop);
  config.mutable_ppo()->set_kl_estimate(estimate);
  return config;
}

PpoReport FirstUpdate(const RunConfig& config) {
  Trainer trainer(config, Trainer::InitialState(config), 1);
  return trainer.Update(SyntheticBatch(config, SnapshotOf(trainer.state(), config), 0));
}

/// Mean over all samples of all epochs: of 40 steps, heads 0, 1 and 2 of three have 14, 13 and 13.
double MeanOfHeads(const PpoReport& report) {
  return (14 * report.head_kl[0] + 13 * report.head_kl[1] + 13 * report.head_kl[2]) / 40;
}

TEST(TrainerTest, OverTheEpochTheDivergenceIsTheMeanOfAllItsSamplesAndOfNoOthers) {
  RunConfig config = StoppingAt(0, KL_ESTIMATE_EPOCH);
  config.mutable_ppo()->set_epochs(1);
  const PpoReport first = FirstUpdate(config);
  EXPECT_NEAR(first.kl, MeanOfHeads(first), 1e-12);
  config.mutable_ppo()->set_epochs(2);
  const PpoReport second = FirstUpdate(config);
  EXPECT_NEAR((first.kl + second.kl) / 2, MeanOfHeads(second), 1e-12);
  config.mutable_ppo()->set_kl_estimate(KL_ESTIMATE_LAST_MINIBATCH);
  EXPECT_GT(std::abs(FirstUpdate(config).kl - second.kl), 1e-4);
}

TEST(TrainerTest, TheStopFollowsTheEstimateThatIsAskedFor) {
  const KlEstimate estimates[] = {KL_ESTIMATE_LAST_MINIBATCH, KL_ESTIMATE_EPOCH};
  for (const KlEstimate estimate : estimates) {
    const PpoReport free = FirstUpdate(StoppingAt(0, estimate));
    ASSERT_EQ(free.epochs, 10);
    const PpoReport stopped = FirstUpdate(StoppingAt(0.02, estimate));
    EXPECT_LT(stopped.epochs, 10);
    EXPECT_GT(stopped.kl, 0.02);
    // An epoch fewer had not passed it.
    RunConfig before = StoppingAt(0, estimate);
    before.mutable_ppo()->set_epochs(stopped.epochs - 1);
    if (stopped.epochs > 1) {
      EXPECT_LE(FirstUpdate(before).kl, 0.02);
    }
  }
}

TEST(TrainerTest, TheFirstBatchIsSeenUnnormalisedAndTheSecondByItsStatistics) {
  const RunConfig config = SmallConfig();
  Trainer trainer(config, Trainer::InitialState(config), 1);
  const PolicySnapshot zero = SnapshotOf(trainer.state(), config);
  EXPECT_EQ(zero.observation_mean, std::vector<float>(39, 0.0F));
  EXPECT_EQ(zero.observation_inv_std, std::vector<float>(39, 1.0F));
  trainer.Update(SyntheticBatch(config, zero, 0));
  const PolicySnapshot one = SnapshotOf(trainer.state(), config);
  EXPECT_NEAR(one.observation_mean[10], 3.0, 0.3);
  EXPECT_NEAR(one.observation_inv_std[10], 1.0, 0.2);
  EXPECT_EQ(one.observation_mean[12], 0);
}

TEST(TrainerTest, ANonFiniteEpisodeStopsTheUpdateAndKeepsTheState) {
  const RunConfig config = SmallConfig();
  Trainer trainer(config, Trainer::InitialState(config), 2);
  const PpoState before = trainer.state();
  auto batch = SyntheticBatch(config, SnapshotOf(before, config), 0);
  batch[4].reward[7] = std::numeric_limits<float>::infinity();
  EXPECT_THROW(trainer.Update(batch), algorithm::NonFiniteUpdate);
  EXPECT_EQ(trainer.state(), before);
}

TEST(TrainerTest, AnUpdateWhoseStdNoActorCanDrawWithIsRefused) {
  const RunConfig config = SmallConfig();
  PpoState state = Trainer::InitialState(config);
  const auto batch = SyntheticBatch(config, SnapshotOf(state, config), 0);
  state.parameters[policy::ActorLayout(policy::ShapeOf(config)).log_std] =
      80;  // finite, and so is its exp
  Trainer trainer(config, state, 1);
  try {
    trainer.Update(batch);
    ADD_FAILURE() << "no actor can act with these weights";
  } catch (const algorithm::NonFiniteUpdate& error) {
    EXPECT_NE(std::string(error.what()).find("a log-std is 80"), std::string::npos) << error.what();
  }
  EXPECT_EQ(trainer.state(), state);
}

TEST(TrainerTest, RefusesAStateOfAnotherShape) {
  const PpoState state = Trainer::InitialState(SmallConfig(MULTIHEAD, 3));
  EXPECT_THROW(Trainer(SmallConfig(MULTIHEAD, 4), state, 1), std::invalid_argument);
}

TEST(InitialStateTest, WeightsAreOrthogonalWithTheirGain) {
  const RunConfig config = SmallConfig();
  const PpoState state = Trainer::InitialState(config);
  const policy::LayerSlice slice =
      policy::ActorLayout(policy::ShapeOf(config)).hidden[0];  // 13 rows of 39
  for (int a = 0; a < slice.outputs; ++a) {
    for (int b = 0; b < slice.outputs; ++b) {
      double dot = 0;
      for (int i = 0; i < slice.inputs; ++i) {
        dot += double{state.parameters[slice.weight + a * slice.inputs + i]} *
               state.parameters[slice.weight + b * slice.inputs + i];
      }
      EXPECT_NEAR(dot, a == b ? 2.0 : 0.0, 1e-6);
    }
  }
}

TEST(InitialStateTest, ASharedCriticBeginsAsTheFirstHeadOfSeparateOnes) {
  RunConfig config = SmallConfig();
  const std::vector<float> separate = Trainer::InitialState(config).parameters;
  config.mutable_policy()->set_critic_heads(CRITIC_HEADS_SHARED);
  const std::vector<float> shared = Trainer::InitialState(config).parameters;
  ASSERT_EQ(separate.size(), shared.size() + 2 * (9 + 1));  // two heads of 9 weights and a bias
  // Of the separate critic: hidden layers, 3 rows of weights, 3 biases (zeros, as all are).
  const std::size_t weights = shared.size() - 1;
  EXPECT_TRUE(
      std::equal(shared.begin(), shared.begin() + std::ptrdiff_t(weights), separate.begin()));
  EXPECT_EQ(shared.back(), 0);
}

TEST(EpisodeCheckTest, AcceptsTheActorsEpisodeAndNamesWhatIsWrongWithOthers) {
  const RunConfig config = SmallConfig();
  const PpoState state = Trainer::InitialState(config);
  const PolicySnapshot snapshot = SnapshotOf(state, config);
  policy::Policy policy(config, snapshot);
  const Episode good = testing::SyntheticEpisode(config, snapshot, 6);
  EXPECT_EQ(algorithm::CheckEpisode(good, policy, config, kCheckKey), std::nullopt);

  const auto reason_of = [&](auto spoil) {
    Episode bad = good;
    spoil(bad);
    return algorithm::CheckEpisode(bad, policy, config, kCheckKey).value_or("accepted");
  };
  const auto expect_reason = [&](const std::string& reason, const std::string& part) {
    EXPECT_NE(reason.find(part), std::string::npos) << reason;
  };
  expect_reason(reason_of([](Episode& e) { e.weights_version = 3; }), "version 3");
  expect_reason(reason_of([](Episode& e) { e.reward.pop_back(); }), "it has 39 steps, not 40");
  expect_reason(reason_of([](Episode& e) { e.observation.pop_back(); }), "observation has length");
  expect_reason(reason_of([](Episode& e) { e.action.push_back(0); }), "action has length");
  expect_reason(reason_of([](Episode& e) { e.reward[3] = NAN; }), "reward is not finite");
  expect_reason(reason_of([](Episode& e) { e.observation[39 * 40] = INFINITY; }), "observation");
  // Finite, and absurd: two of the first sum up to infinity, one of the second spoils a scale.
  for (const float reward : {3e38F, 1e30F, -1e30F, 1001.0F}) {
    expect_reason(reason_of([=](Episode& e) { e.reward[3] = reward; }), "reward is out of range");
  }
  for (const float observation : {1e20F, -1e20F, 1.1e6F}) {
    expect_reason(reason_of([=](Episode& e) { e.observation[39 * 40] = observation; }),
                  "observation is out of range");
  }
  expect_reason(reason_of([](Episode& e) { e.reward[3] = -1000; }), "accepted");
  expect_reason(reason_of([](Episode& e) { e.observation[39 * 40] = 1e6F; }), "accepted");
  expect_reason(reason_of([](Episode& e) { e.head[20] = 0; }), "step 20 names head 0");
  expect_reason(reason_of([](Episode& e) { e.flags[39] = 0; }), "flags");
  expect_reason(reason_of([](Episode& e) { e.flags[1] = kStepTerminated; }), "flags");
  expect_reason(reason_of([](Episode& e) { e.number = 7; }), "log-probability");
  // One bit of one log-probability, and one bit of one action.
  expect_reason(reason_of([](Episode& e) { e.log_prob[9] = std::nextafter(e.log_prob[9], 9.0F); }),
                "step 9");
  expect_reason(reason_of([](Episode& e) { e.action[50] = std::nextafter(e.action[50], 9.0F); }),
                "step 12");
}

// An episode of an actor under another schedule is wrong at the first step of another head; with
// only its tags put right, in what that head does.
TEST(EpisodeCheckTest, RefusesTheHeadsOfAnotherSchedule) {
  const Schedule schedules[] = {SCHEDULE_BLOCKS, SCHEDULE_INTERLEAVED, SCHEDULE_SHUFFLED};
  for (const Schedule played : schedules) {
    for (const Schedule asked : schedules) {
      RunConfig config = SmallConfig();
      PolicySnapshot snapshot = SnapshotOf(Trainer::InitialState(config), config);
      config.mutable_policy()->set_schedule(played);
      Episode episode = testing::SyntheticEpisode(config, snapshot, 6);
      config.mutable_policy()->set_schedule(asked);
      policy::Policy policy(config, snapshot);
      const auto reason =
          algorithm::CheckEpisode(episode, policy, config, kCheckKey).value_or("accepted");
      if (played == asked) {
        EXPECT_EQ(reason, "accepted");
        continue;
      }
      EXPECT_NE(reason.find("the schedule gives"), std::string::npos) << reason;
      const auto schedule = policy::HeadSchedule::OfTraining(config, 6);
      for (int t = 0; t < 40; ++t) episode.head[t] = std::uint16_t(schedule.HeadAt(t));
      const auto disguised =
          algorithm::CheckEpisode(episode, policy, config, kCheckKey).value_or("accepted");
      EXPECT_NE(disguised.find("log-probability"), std::string::npos) << disguised;
    }
  }
}

TEST(EpisodeCheckTest, RefusesTheHeadOrderOfAnotherEpisodeOrSeed) {
  RunConfig config = SmallConfig();
  config.mutable_policy()->set_schedule(SCHEDULE_SHUFFLED);
  const PolicySnapshot snapshot = SnapshotOf(Trainer::InitialState(config), config);
  policy::Policy policy(config, snapshot);
  // One policy judges episodes of any order, in turn.
  int refused = 0;
  for (std::uint64_t number = 0; number < 20; ++number) {
    Episode episode = testing::SyntheticEpisode(config, snapshot, number);
    EXPECT_EQ(algorithm::CheckEpisode(episode, policy, config, kCheckKey), std::nullopt);
    ++episode.number;
    const auto reason =
        algorithm::CheckEpisode(episode, policy, config, kCheckKey).value_or("accepted");
    EXPECT_NE(reason, "accepted");
    refused += reason.find("the schedule gives") != std::string::npos ? 1 : 0;
  }
  EXPECT_GE(refused, 12) << "of 20 neighbours, a sixth has the same order of three heads";
  Episode episode = testing::SyntheticEpisode(config, snapshot, 0);
  config.set_seed(8);
  EXPECT_NE(algorithm::CheckEpisode(episode, policy, config, kCheckKey), std::nullopt);
}

TEST(EpisodeCheckTest, TheLastStepsOfAHorizonThatIsNoMultipleOfFourAreCheckedToo) {
  RunConfig config = SmallConfig();
  config.mutable_environment()->set_horizon(43);
  const PolicySnapshot snapshot = SnapshotOf(Trainer::InitialState(config), config);
  policy::Policy policy(config, snapshot);
  Episode episode = testing::SyntheticEpisode(config, snapshot, 6);
  EXPECT_EQ(algorithm::CheckEpisode(episode, policy, config, kCheckKey), std::nullopt);
  episode.log_prob[42] = std::nextafter(episode.log_prob[42], 9.0F);
  EXPECT_NE(algorithm::CheckEpisode(episode, policy, config, kCheckKey)
                .value_or("accepted")
                .find("step 42"),
            std::string::npos);
}

TEST(EpisodeCheckTest, ASampleFindsAWrongStepInItAndNoOther) {
  RunConfig config = SmallConfig();
  config.mutable_collection()->set_check_share(0.3);
  const PolicySnapshot snapshot = SnapshotOf(Trainer::InitialState(config), config);
  policy::Policy policy(config, snapshot);
  const Episode good = testing::SyntheticEpisode(config, snapshot, 6);
  int found = 0;
  for (std::size_t t = 0; t < good.log_prob.size(); ++t) {
    Episode bad = good;
    bad.log_prob[t] += 1;
    found += algorithm::CheckEpisode(bad, policy, config, kCheckKey).has_value() ? 1 : 0;
  }
  EXPECT_EQ(algorithm::CheckEpisode(good, policy, config, kCheckKey), std::nullopt);
  EXPECT_GE(found, 5);
  EXPECT_LE(found, 20);
}

// Actors know the run's seed and every episode's number: they must not know which steps to get
// right.
TEST(EpisodeCheckTest, TheKeyDecidesWhatIsSampledAndTheRunSeedDoesNot) {
  RunConfig config = SmallConfig();
  config.mutable_collection()->set_check_share(0.3);
  const PolicySnapshot snapshot = SnapshotOf(Trainer::InitialState(config), config);
  policy::Policy policy(config, snapshot);
  const Episode good = testing::SyntheticEpisode(config, snapshot, 6);
  std::set<std::vector<bool>> samples;
  for (std::uint64_t key = 0; key < 5; ++key) {
    std::vector<bool> sample;
    for (std::size_t t = 0; t < good.log_prob.size(); ++t) {
      Episode bad = good;
      bad.log_prob[t] += 1;
      sample.push_back(algorithm::CheckEpisode(bad, policy, config, key).has_value());
    }
    samples.insert(sample);
  }
  EXPECT_EQ(samples.size(), 5U);
}

TEST(EpisodeCheckTest, AToleranceLetsSmallDifferencesPassAndNoLargeOnes) {
  RunConfig config = SmallConfig();
  const PolicySnapshot snapshot = SnapshotOf(Trainer::InitialState(config), config);
  policy::Policy policy(config, snapshot);
  Episode episode = testing::SyntheticEpisode(config, snapshot, 6);
  episode.log_prob[9] += 1e-5F;
  config.mutable_collection()->set_check_tolerance(1e-4);
  EXPECT_EQ(algorithm::CheckEpisode(episode, policy, config, kCheckKey), std::nullopt);
  episode.log_prob[9] += 1e-2F;
  EXPECT_NE(algorithm::CheckEpisode(episode, policy, config, kCheckKey), std::nullopt);
}

}  // namespace
}  // namespace metronome::ppo
