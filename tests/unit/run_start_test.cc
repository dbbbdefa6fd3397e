#include "learner/run_start.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/build_info.h"
#include "common/config.h"
#include "common/sha256.h"
#include "learner/trainer.h"
#include "tests/unit/synthetic_run.h"
#include "tests/unit/temporary_folder.h"

namespace metronome {
namespace {

namespace fs = std::filesystem;

class RunStartTest : public TemporaryFolderTest {
 protected:
  RunStartTest() {
    options_.run = "demo";
    options_.folder = root_ + "/demo";
    options_.config = Resolve(testing::SmallConfig());
    fs::create_directories(options_.folder);
  }

  [[nodiscard]] std::string Checkpoints() const { return options_.folder + "/checkpoints"; }

  /// What the run's learner left at `version`.
  [[nodiscard]] Checkpoint At(std::uint64_t version) const {
    Checkpoint checkpoint;
    checkpoint.config = options_.config;
    checkpoint.engine = EngineName();
    checkpoint.incarnation = 3;
    checkpoint.logs = {100 * version, 200 * version, 5};
    TrainState& state = checkpoint.state = Trainer::InitialState(options_.config);
    state.version = version;
    state.steps = version * 400;
    state.adam_m.assign(state.adam_m.size(), 0.5F);
    state.adam_steps = 7;
    state.observation = {std::vector<double>(39, 1), std::vector<double>(39, 2), 400};
    state.reward_return = {{1}, {2}, 3};
    state.canonical_digest = "00ff";
    state.episodes_used = version * 10;
    state.parameters[0] = static_cast<float>(version);
    return checkpoint;
  }

  [[nodiscard]] std::string Refusal() const {
    try {
      StartOf(options_);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "none";
  }

  RunOptions options_;
};

TEST_F(RunStartTest, AResumedRunGoesOnFromTheNewestWholeCheckpointAndItsLogs) {
  CheckpointStore store(Checkpoints(), 5);
  for (std::uint64_t version = 1; version <= 3; ++version) store.Save(At(version));
  std::ofstream(Checkpoints() + "/000003.ckpt", std::ios::trunc) << "torn";
  options_.resume = true;
  const RunStart start = StartOf(options_);
  EXPECT_TRUE(start.resumed);
  EXPECT_EQ(start.checkpoint.state, At(2).state);
  EXPECT_EQ(start.checkpoint.logs, At(2).logs);
  EXPECT_TRUE(fs::exists(Checkpoints() + "/000003.ckpt.damaged"));
}

TEST_F(RunStartTest, AStartThatIsRefusedMovesNothing) {
  CheckpointStore store(Checkpoints(), 5);
  for (std::uint64_t version = 1; version <= 2; ++version) store.Save(At(version));
  std::ofstream(Checkpoints() + "/000002.ckpt", std::ios::trunc) << "torn";
  options_.resume = true;
  options_.config.set_seed(6);
  EXPECT_NE(Refusal().find("belongs to another configuration"), std::string::npos) << Refusal();
  EXPECT_TRUE(fs::exists(Checkpoints() + "/000002.ckpt"));
}

TEST_F(RunStartTest, ARunThatNeverHadACheckpointBeginsAtVersion0) {
  options_.resume = true;
  std::ofstream(options_.folder + "/progress.csv") << "steps,update\n";
  const RunStart start = StartOf(options_);
  EXPECT_FALSE(start.resumed);
  EXPECT_EQ(start.checkpoint.state, Trainer::InitialState(options_.config));
}

TEST_F(RunStartTest, ARunWhoseCheckpointsAreLostDoesNotBeginAgain) {
  options_.resume = true;
  std::ofstream(options_.folder + "/progress.csv") << "steps,update\n400,1\n800,2\n";
  EXPECT_THROW(StartOf(options_), CannotStart);
  EXPECT_NE(Refusal().find("tells of 2 updates"), std::string::npos) << Refusal();
  EXPECT_NE(Refusal().find("another --run"), std::string::npos);
}

TEST_F(RunStartTest, OfAnotherRunWeightsAndObservationStatisticsAreTakenAlone) {
  const Checkpoint source = At(5);
  const std::string path = CheckpointStore(root_ + "/other", 5).Save(source);
  options_.config.mutable_policy()->set_initial_weights(path);
  options_.config.set_seed(99);
  TrainState expected = Trainer::InitialState(options_.config);
  expected.parameters = source.state.parameters;
  expected.observation = source.state.observation;
  // Killed before its first checkpoint, the run begins in the same way.
  for (const bool resume : {false, true}) {
    options_.resume = resume;
    const RunStart start = StartOf(options_);
    EXPECT_EQ(start.checkpoint.state, expected);
    EXPECT_EQ(start.checkpoint.logs, LogOffsets());
    EXPECT_EQ(start.checkpoint.initial_weights_sha256, WeightsSha256(source.state.parameters));
    EXPECT_FALSE(start.resumed);
  }
}

TEST_F(RunStartTest, ACheckpointRemembersTheWeightsThatItsRunBeganWith) {
  Checkpoint checkpoint = At(1);
  checkpoint.initial_weights_sha256 = "00ff";
  EXPECT_EQ(DecodeCheckpoint(EncodeCheckpoint(checkpoint), "x").initial_weights_sha256, "00ff");
}

}  // namespace
}  // namespace metronome
