#include "learner/ppo/ppo_state.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "common/policy/snapshot.h"
#include "common/process/sha256.h"
#include "learner/algorithm/algorithm_factory.h"
#include "learner/ppo/ppo_algorithm.h"
#include "learner/ppo/trainer.h"
#include "tests/unit/support/synthetic_run.h"

namespace metronome::ppo {
namespace {

using testing::SmallConfig;
using testing::SyntheticBatch;

/// A state whose every number needs all its bits.
PpoState SomeState(const RunConfig& config) {
  PpoState state = Trainer::InitialState(config);
  state.version = 7;
  state.steps = 56000;
  state.episodes_used = 112;
  state.parameters[0] = std::numeric_limits<float>::denorm_min();
  state.parameters[1] = -0.0F;
  state.adam_m.assign(state.parameters.size(), 1.0F / 3);
  state.adam_v.assign(state.parameters.size(), 1.0e-30F);
  state.adam_steps = 560;
  state.observation = {{std::vector<double>(39, 1.0 / 3), std::vector<double>(39, 1e300), 56000}};
  state.reward_return = {{{-0.1}, {std::numeric_limits<double>::denorm_min()}, 3}};
  state.previous_actor.assign(policy::ActorLayout(policy::ShapeOf(config)).size, 0.7F);
  state.previous_observation = {
      {std::vector<double>(39, 2.0 / 3), std::vector<double>(39, 1), 48000}};
  return state;
}

std::string Refusal(const checkpoint::TrainState& state, const RunConfig& config) {
  try {
    static_cast<void>(DecodePpoState(state, config));
  } catch (const algorithm::UnusableState& error) {
    return error.what();
  }
  return "none";
}

TEST(PpoStateTest, EveryBitComesBack) {
  const RunConfig config = SmallConfig();
  for (const PpoState& state : {SomeState(config), Trainer::InitialState(config)}) {
    const checkpoint::TrainState encoded = EncodePpoState(state, config);
    EXPECT_EQ(DecodePpoState(encoded, config), state);
    EXPECT_EQ(encoded.policy, SnapshotOf(state, config));
    EXPECT_EQ(encoded.weights.count, state.parameters.size());
    EXPECT_EQ(encoded.weights.sha256, process::WeightsSha256(state.parameters));
    EXPECT_EQ(encoded.version, state.version);
    EXPECT_EQ(EncodePpoState(DecodePpoState(encoded, config), config), encoded);
  }
}

TEST(PpoStateTest, WhatHeadsShareComesBackAndFitsTheConfiguration) {
  RunConfig config = SmallConfig();
  config.mutable_ppo()->set_shared_heads(true);
  PpoState state = SomeState(config);
  state.shared.m[0] = 1.0F / 3;
  state.shared.v[1] = 1e-30F;
  EXPECT_EQ(DecodePpoState(EncodePpoState(state, config), config), state);
  state.shared.v.pop_back();
  EXPECT_NE(
      Refusal(EncodePpoState(state, config), config).find("second moment of what heads share"),
      std::string::npos);
}

TEST(PpoStateTest, EarlierEpisodesComeBackAndFitTheConfiguration) {
  const RunConfig config = SmallConfig();
  PpoState state = SomeState(config);
  state.earlier = SyntheticBatch(config, SnapshotOf(state, config), 3);
  EXPECT_EQ(DecodePpoState(EncodePpoState(state, config), config), state);
  state.earlier[1].action.pop_back();
  EXPECT_NE(Refusal(EncodePpoState(state, config), config).find("episode 31's action has 159"),
            std::string::npos);
  state.earlier[1] = state.earlier[2];
  state.earlier[1].head[7] = 3;
  EXPECT_NE(Refusal(EncodePpoState(state, config), config).find("a head that the network has not"),
            std::string::npos);
}

TEST(PpoStateTest, WhatDoesNotFitTheConfigurationIsRefusedByName) {
  const RunConfig config = SmallConfig();
  PpoState state = SomeState(config);
  state.adam_v.pop_back();
  EXPECT_NE(Refusal(EncodePpoState(state, config), config).find("Adam's second moment has"),
            std::string::npos);
  state = SomeState(config);
  state.reward_return[0].m2.clear();
  EXPECT_NE(Refusal(EncodePpoState(state, config), config).find("the return statistics has 0"),
            std::string::npos);
  EXPECT_NE(Refusal(EncodePpoState(SomeState(config), config), SmallConfig(MULTIHEAD, 4))
                .find("another shape: the network has"),
            std::string::npos);
  checkpoint::TrainState torn = EncodePpoState(SomeState(config), config);
  torn.algorithm.bytes.pop_back();
  EXPECT_EQ(Refusal(torn, config), "its state of ppo is not one");
}

TEST(PpoStateTest, AnotherFormatOrAlgorithmIsRefusedByName) {
  const RunConfig config = SmallConfig();
  checkpoint::TrainState state = EncodePpoState(SomeState(config), config);
  state.algorithm.format = kPpoStateFormat + 1;
  EXPECT_EQ(Refusal(state, config),
            "its state of ppo has format 4, this build reads formats 1 to 3; use a build that "
            "knows it");
  state.algorithm = {"sac", 1, ""};
  EXPECT_EQ(Refusal(state, config), "its state is of the algorithm sac, this run's is ppo");
}

// Coordinator, checkpoints and logs see the trainer, update by update.
TEST(PpoAlgorithmTest, GoesOnFromItsOwnStateAsTheTrainerDoes) {
  const RunConfig config = SmallConfig(MULTIHEAD, 3, 1);
  const auto factory = MakePpoFactory();
  Trainer trainer(config, Trainer::InitialState(config), 1);
  checkpoint::TrainState state = factory->InitialState(config, nullptr);
  for (std::uint64_t version = 0; version < 3; ++version) {
    const auto algorithm = factory->Make(config, state, {2, 99});
    EXPECT_EQ(algorithm->counters(), static_cast<const checkpoint::RunCounters&>(trainer.state()));
    EXPECT_EQ(algorithm->Snapshot(), SnapshotOf(trainer.state(), config));
    if (version > 0) {
      EXPECT_EQ(algorithm->PreviousSnapshot(), PreviousSnapshotOf(trainer.state(), config));
    }
    const PolicySnapshot behaviour =
        version > 0 ? algorithm->PreviousSnapshot() : algorithm->Snapshot();
    const auto batch = SyntheticBatch(config, behaviour, version);
    EXPECT_EQ(algorithm->Check(batch[2], behaviour), std::nullopt);
    const PpoReport want = trainer.Update(batch);
    const algorithm::UpdateReport report = algorithm->Update(batch);
    EXPECT_EQ(report.steps, want.steps);
    EXPECT_EQ(report.mean_return, want.mean_return);
    const std::vector<algorithm::Metric> columns = algorithm->Metrics();
    ASSERT_EQ(report.metrics.size(), columns.size());
    for (std::size_t i = 0; i < columns.size(); ++i) {
      EXPECT_EQ(report.metrics[i].column, columns[i].column);
      EXPECT_FALSE(columns[i].meaning.empty()) << columns[i].column;
    }
    state = algorithm->State();
    EXPECT_EQ(state, EncodePpoState(trainer.state(), config));
  }
}

TEST(PpoReportTest, ColumnsAreThoseThatOthersReadByNameAndOneAHead) {
  const PpoReport report = EmptyPpoReport(2);
  std::vector<std::string> columns;
  for (const algorithm::Metric& metric : PpoMetrics(report)) columns.push_back(metric.column);
  EXPECT_EQ(columns, (std::vector<std::string>{
                         "policy_loss", "value_loss", "entropy", "kl", "clip_share",
                         "explained_variance", "gradient_norm", "learning_rate", "reward_scale",
                         "epochs", "lag", "entropy_head0", "entropy_head1", "kl_head0", "kl_head1",
                         "clip_share_head0", "clip_share_head1", "std_head0", "std_head1"}));
  PpoReport uneven = report;
  uneven.head_std.pop_back();
  EXPECT_THROW(PpoMetrics(uneven), std::invalid_argument);
}

}  // namespace
}  // namespace metronome::ppo
