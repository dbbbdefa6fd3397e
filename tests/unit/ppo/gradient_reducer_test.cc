#include "learner/ppo/gradient_reducer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "common/numbers/random.h"
#include "learner/ppo/minibatch_step.h"
#include "learner/ppo/mlp.h"
#include "learner/ppo/trainer.h"
#include "tests/unit/support/synthetic_run.h"

namespace metronome::ppo {
namespace {

TEST(ShardGroupsTest, AreSingleShardsUpToTheMostAndWholeShardsInOrderBeyond) {
  for (const std::size_t shards : {1, 2, 63, 64, 65, 128, 129, 196, 1000}) {
    const ShardGroups groups = ShardGroups::Of(shards);
    EXPECT_LE(groups.count(), 64U) << shards;
    if (shards <= 64) {
      EXPECT_EQ(groups.count(), shards);
    }
    std::size_t next = 0;
    for (std::size_t g = 0; g < groups.count(); ++g) {
      EXPECT_EQ(groups.begin(g), next) << shards;
      EXPECT_GT(groups.end(g), groups.begin(g)) << shards;
      next = groups.end(g);
    }
    EXPECT_EQ(next, shards);
  }
}

TEST(GradientReducerTest, SumsTheGroupsInTheirOrderOnAnyNumberOfThreads) {
  constexpr std::size_t kParameters = 10000, kGroups = 7;
  std::vector<float> want(kParameters, 0.0F);
  for (const int threads : {1, 2, 5}) {
    WorkerTeam team(threads);
    GradientReducer reducer(9, kParameters, team);  // two are left out
    numbers::RandomStream random(numbers::RandomPurpose::kEvaluate, 1, 2, 3);
    for (std::size_t g = 0; g < 9; ++g) {
      for (std::size_t i = 0; i < kParameters; ++i) reducer.Of(g)[i] = float(random.Normal());
    }
    for (std::size_t i = 0; i < kParameters; ++i) {
      want[i] = reducer.Of(0)[i];
      for (std::size_t g = 1; g < kGroups; ++g) want[i] += reducer.Of(g)[i];
    }
    const double norm = reducer.Reduce(kGroups);
    EXPECT_EQ(reducer.sum(), want);
    EXPECT_NEAR(norm, std::sqrt(std::inner_product(want.begin(), want.end(), want.begin(), 0.0)),
                1e-6 * norm);
  }
}

/// A batch of 400 samples, from which minibatches of any size are drawn, with repetition.
class GroupedMinibatchTest : public ::testing::TestWithParam<std::size_t> {
 protected:
  GroupedMinibatchTest() {
    config_.mutable_ppo()->set_minibatch(std::int32_t(GetParam()));
    initial_ = Trainer::InitialState(config_);
    const PolicySnapshot snapshot = SnapshotOf(initial_, config_);
    WorkerTeam team(1);
    batch_ = BuildBatch({config_,
                         testing::SyntheticBatch(config_, snapshot, 0),
                         snapshot,
                         initial_.parameters.data(),
                         {0.7F}},
                        team);
    for (std::size_t i = 0; i < GetParam(); ++i) {
      samples_.push_back(std::uint32_t(i * 7 % batch_.size()));
    }
  }

  std::vector<float> Gradient(int threads) {
    WorkerTeam team(threads);
    MinibatchStep step(config_, team);
    OptimiserState state{initial_.parameters, initial_.adam_m, initial_.adam_v, 0};
    step.Run(batch_, samples_, {1e-3, 0.01}, state);
    gradients_held_ = step.gradients_held();
    return step.gradient();
  }

  /// The critic's gradient of shards [begin, end) of the minibatch as it is ordered by head.
  [[nodiscard]] std::vector<float> CriticGradient(std::size_t begin, std::size_t end) const {
    std::vector<std::uint32_t> ordered = samples_;
    std::stable_sort(ordered.begin(), ordered.end(),
                     [&](auto a, auto b) { return batch_.head[a] < batch_.head[b]; });
    Mlp critic(policy::CriticLayout(policy::ShapeOf(config_)));
    const float* block =
        initial_.parameters.data() + policy::ActorLayout(policy::ShapeOf(config_)).size;
    std::vector<float> gradient(critic.layout().size, 0.0F);
    const float weight = float(config_.ppo().value_coefficient()) * (1.0F / float(samples_.size()));
    for (std::size_t first = begin * 128; first < std::min(end * 128, ordered.size());
         first += 128) {
      const std::size_t count = std::min<std::size_t>(128, ordered.size() - first);
      Eigen::MatrixXf input(batch_.input.rows(), Eigen::Index(count));
      std::vector<HeadRun> runs;
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t sample = ordered[first + i];
        input.col(Eigen::Index(i)) = batch_.input.col(sample);
        const std::int32_t head = batch_.head[sample];
        if (runs.empty() || runs.back().head != head) runs.push_back({head, std::int32_t(i), 0});
        ++runs.back().count;
      }
      Eigen::MatrixXf d_value = critic.Forward(block, input, runs);
      for (std::size_t i = 0; i < count; ++i) {
        const auto c = Eigen::Index(i);
        d_value(0, c) = weight * (d_value(0, c) - batch_.target[ordered[first + i]]);
      }
      critic.Backward(block, input, runs, d_value, gradient.data());
    }
    return gradient;
  }

  RunConfig config_ = testing::SmallConfig();
  PpoState initial_;
  TrainingBatch batch_;
  std::vector<std::uint32_t> samples_;
  std::size_t gradients_held_ = 0;
};

TEST_P(GroupedMinibatchTest, TheGradientIsTheSumOverGroupsAndNoThreadChangesIt) {
  const std::vector<float> whole = Gradient(1);
  EXPECT_LE(gradients_held_, 64U);
  const std::size_t shards = (samples_.size() + 127) / 128;
  const std::size_t a_group = (shards + 63) / 64;  // 1 up to 8192 samples
  std::vector<float> want = CriticGradient(0, a_group);
  for (std::size_t first = a_group; first < shards; first += a_group) {
    const std::vector<float> group = CriticGradient(first, first + a_group);
    for (std::size_t i = 0; i < want.size(); ++i) want[i] += group[i];
  }
  const auto critic = whole.end() - std::ptrdiff_t(want.size());
  EXPECT_EQ(std::vector<float>(critic, whole.end()), want);
  EXPECT_EQ(Gradient(2), whole);
  EXPECT_EQ(Gradient(3), whole);
}

INSTANTIATE_TEST_SUITE_P(Samples, GroupedMinibatchTest,
                         ::testing::Values(100, 300, 8192, 8193, 25000));

}  // namespace
}  // namespace metronome::ppo
