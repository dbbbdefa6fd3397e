#include "learner/sac/trainer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "learner/algorithm/algorithm.h"
#include "learner/algorithm/episode_check.h"
#include "learner/sac/sac_state.h"
#include "tests/unit/support/synthetic_run.h"

namespace metronome::sac {
namespace {

using testing::SmallSacConfig;
using testing::SyntheticBatch;

PolicySnapshot BehaviourOf(const SacState& state, const RunConfig& config) {
  const bool lags = config.collection().overlap() > 0 && state.version > 0;
  return lags ? PreviousSnapshotOf(state, config) : SnapshotOf(state, config);
}

SacState TrainFor(const RunConfig& config, int updates, int threads) {
  Trainer trainer(config, InitialSacState(config), {}, threads);
  for (int i = 0; i < updates; ++i) {
    const SacState& state = trainer.state();
    trainer.Update(SyntheticBatch(config, BehaviourOf(state, config), state.version));
  }
  return trainer.state();
}

class SacBitsTest : public ::testing::TestWithParam<std::tuple<Method, int>> {};

TEST_P(SacBitsTest, AnyNumberOfThreadsGivesTheSameState) {
  const RunConfig config = SmallSacConfig(std::get<0>(GetParam()), 3, std::get<1>(GetParam()));
  const SacState one = TrainFor(config, 5, 1);
  EXPECT_EQ(one.optimiser.gradient_steps, 8U);  // 0.3 * 1600 / 60
  EXPECT_EQ(TrainFor(config, 5, 2), one);
  EXPECT_EQ(TrainFor(config, 5, 5), one);
}

INSTANTIATE_TEST_SUITE_P(Arms, SacBitsTest,
                         ::testing::Combine(::testing::Values(MULTIHEAD, SINGLE, SINGLE_TIME),
                                            ::testing::Values(0, 1)));

TEST(SacTrainerTest, LearnsNothingBeforeTheRandomEpisodesAreThereAndThenByTheRatio) {
  const RunConfig config = SmallSacConfig();  // an update's 400 steps are random
  const SacState first = TrainFor(config, 1, 1);
  EXPECT_EQ(first.optimiser, InitialSacState(config).optimiser);
  EXPECT_EQ(first.observation[0].count, 400);
  EXPECT_EQ(TrainFor(config, 2, 1).optimiser.gradient_steps, 2U);  // 0.3 * 400 / 60
}

TEST(SacTrainerTest, GoesOnFromAStateAndItsReplayAsIfNothingHadHappened) {
  const RunConfig config = SmallSacConfig();
  Trainer whole(config, InitialSacState(config), {}, 1);
  std::vector<Episode> replay;
  const auto update = [&config](Trainer& trainer) {
    const SacState& state = trainer.state();
    const auto batch = SyntheticBatch(config, SnapshotOf(state, config), state.version);
    trainer.Update(batch);
    return batch;
  };
  for (int i = 0; i < 4; ++i) {
    const auto batch = update(whole);
    replay.insert(replay.end(), batch.begin(), batch.end());
  }
  replay.erase(replay.begin(), replay.end() - 25);  // 1000 steps are kept
  Trainer resumed(config, whole.state(), replay, 2);
  Trainer without(config, whole.state(), {}, 2);
  for (Trainer* trainer : {&whole, &resumed, &without}) update(*trainer);
  EXPECT_EQ(resumed.state(), whole.state());
  EXPECT_NE(without.state(), whole.state());
}

TEST(SacTrainerTest, ItsEpisodesPassTheCheckRandomOnesToo) {
  const RunConfig config = SmallSacConfig();
  for (const int updates : {0, 2}) {
    const SacState state = TrainFor(config, updates, 1);
    const PolicySnapshot snapshot = SnapshotOf(state, config);
    policy::Policy policy(config, snapshot);
    std::vector<Episode> batch = SyntheticBatch(config, snapshot, state.version);
    for (const Episode& episode : batch) {
      for (const float action : episode.action) ASSERT_LE(std::abs(action), 1);
      EXPECT_EQ(algorithm::CheckEpisode(episode, policy, config, 1), std::nullopt);
    }
    batch[1].action[7] = std::nextafter(batch[1].action[7], 2.0F);
    EXPECT_NE(algorithm::CheckEpisode(batch[1], policy, config, 1), std::nullopt);
  }
}

TEST(SacTrainerTest, AnUpdateThatIsNotFiniteLeavesTheStateAsItWas) {
  const RunConfig config = SmallSacConfig();
  SacState state = TrainFor(config, 1, 1);
  state.optimiser.critics[3] = std::numeric_limits<float>::infinity();
  Trainer trainer(config, state, {}, 1);
  const auto batch = SyntheticBatch(config, SnapshotOf(state, config), 1);
  EXPECT_THROW(trainer.Update(batch), algorithm::NonFiniteUpdate);
  EXPECT_EQ(trainer.state(), state);
}

TEST(SacStateTest, EveryBitComesBack) {
  const RunConfig config = SmallSacConfig(MULTIHEAD, 3, 1);
  const SacState state = TrainFor(config, 3, 1);
  const checkpoint::TrainState encoded = EncodeSacState(state, config);
  EXPECT_EQ(DecodeSacState(encoded, config), state);
  EXPECT_EQ(encoded.policy, SnapshotOf(state, config));
}

}  // namespace
}  // namespace metronome::sac
