#include "learner/run/run_start.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/config/config.h"
#include "common/process/build_info.h"
#include "common/process/sha256.h"
#include "learner/ppo/ppo_algorithm.h"
#include "learner/ppo/ppo_state.h"
#include "learner/ppo/trainer.h"
#include "tests/unit/support/environments.h"
#include "tests/unit/support/synthetic_run.h"
#include "tests/unit/support/temporary_folder.h"

namespace metronome::run {
namespace {

namespace fs = std::filesystem;

class RunStartTest : public TemporaryFolderTest {
 protected:
  RunStartTest() {
    request_.run = "demo";
    request_.folder = root_ + "/demo";
    request_.config = config::Resolve(testing::SmallConfig());
    request_.specs = test::Describe;
    fs::create_directories(request_.folder);
  }

  [[nodiscard]] std::string Checkpoints() const { return request_.folder + "/checkpoints"; }

  /// The checkpoint that the run's learner left at `version`.
  [[nodiscard]] checkpoint::Checkpoint At(std::uint64_t version) const {
    checkpoint::Checkpoint checkpoint;
    checkpoint.config = request_.config;
    checkpoint.engine = process::EngineName();
    checkpoint.incarnation = 3;
    checkpoint.logs = {100 * version, 200 * version, 5};
    ppo::PpoState state = ppo::Trainer::InitialState(request_.config);
    state.version = version;
    state.steps = version * 400;
    state.adam_m.assign(state.adam_m.size(), 0.5F);
    state.adam_steps = 7;
    state.observation = {{std::vector<double>(39, 1), std::vector<double>(39, 2), 400}};
    state.reward_return = {{{1}, {2}, 3}};
    state.episodes_used = version * 10;
    state.parameters[0] = static_cast<float>(version);
    checkpoint.state = ppo::EncodePpoState(state, request_.config);
    checkpoint.state.canonical_digest = "00ff";
    return checkpoint;
  }

  [[nodiscard]] std::string Refusal() const {
    try {
      RunStart start = StartOf(request_, *ppo_);
      AlgorithmOf(start, *ppo_, {});
    } catch (const std::exception& error) {
      return error.what();
    }
    return "none";
  }

  RunRequest request_;
  std::shared_ptr<const algorithm::AlgorithmFactory> ppo_ = ppo::MakePpoFactory();
};

TEST_F(RunStartTest, AResumedRunGoesOnFromTheNewestWholeCheckpointAndItsLogs) {
  checkpoint::CheckpointStore store(Checkpoints(), 5);
  for (std::uint64_t version = 1; version <= 3; ++version) store.Save(At(version));
  std::ofstream(Checkpoints() + "/000003.ckpt", std::ios::trunc) << "torn";
  request_.resume = true;
  const RunStart start = StartOf(request_, *ppo_);
  EXPECT_TRUE(start.resumed);
  EXPECT_EQ(start.checkpoint.state, At(2).state);
  EXPECT_EQ(start.checkpoint.logs, At(2).logs);
  EXPECT_TRUE(fs::exists(Checkpoints() + "/000003.ckpt.damaged"));
}

TEST_F(RunStartTest, AStartThatIsRefusedMovesNothing) {
  checkpoint::CheckpointStore store(Checkpoints(), 5);
  for (std::uint64_t version = 1; version <= 2; ++version) store.Save(At(version));
  std::ofstream(Checkpoints() + "/000002.ckpt", std::ios::trunc) << "torn";
  request_.resume = true;
  request_.config.set_seed(6);
  EXPECT_NE(Refusal().find("belongs to another configuration"), std::string::npos) << Refusal();
  EXPECT_TRUE(fs::exists(Checkpoints() + "/000002.ckpt"));
}

TEST_F(RunStartTest, ARunThatNeverHadACheckpointBeginsAtVersion0) {
  request_.resume = true;
  std::ofstream(request_.folder + "/progress.csv") << "steps,update\n";
  const RunStart start = StartOf(request_, *ppo_);
  EXPECT_FALSE(start.resumed);
  EXPECT_EQ(start.checkpoint.state, ppo_->InitialState(request_.config, nullptr));
}

TEST_F(RunStartTest, ARunWhoseCheckpointsAreLostDoesNotBeginAgain) {
  request_.resume = true;
  std::ofstream(request_.folder + "/progress.csv") << "steps,update\n400,1\n800,2\n";
  EXPECT_THROW(StartOf(request_, *ppo_), CannotStart);
  EXPECT_NE(Refusal().find("tells of 2 updates"), std::string::npos) << Refusal();
  EXPECT_NE(Refusal().find("another --run"), std::string::npos);
}

TEST_F(RunStartTest, OfAnotherRunWeightsAndObservationStatisticsAreTakenAlone) {
  const checkpoint::Checkpoint source = At(5);
  const std::string path = checkpoint::CheckpointStore(root_ + "/other", 5).Save(source);
  request_.config.mutable_policy()->set_initial_weights(path);
  request_.config.set_seed(99);
  ppo::PpoState expected = ppo::Trainer::InitialState(request_.config);
  const ppo::PpoState other = ppo::DecodePpoState(source.state, request_.config);
  expected.parameters = other.parameters;
  expected.observation = other.observation;
  // Killed before its first checkpoint, the run begins in the same way.
  for (const bool resume : {false, true}) {
    request_.resume = resume;
    const RunStart start = StartOf(request_, *ppo_);
    EXPECT_EQ(start.checkpoint.state, ppo::EncodePpoState(expected, request_.config));
    EXPECT_EQ(start.checkpoint.logs, checkpoint::LogOffsets());
    EXPECT_EQ(start.checkpoint.initial_weights_sha256, process::WeightsSha256(other.parameters));
    EXPECT_FALSE(start.resumed);
  }
}

TEST_F(RunStartTest, AStateOfALaterFormatOfTheAlgorithmIsRefusedByName) {
  checkpoint::Checkpoint later = At(2);
  later.state.algorithm.format = ppo::kPpoStateFormat + 1;
  const std::string path = checkpoint::CheckpointStore(Checkpoints(), 5).Save(later);
  request_.resume = true;
  const std::string known = std::to_string(ppo::kPpoStateFormat);
  const std::string unknown =
      "its state of ppo has format " + std::to_string(ppo::kPpoStateFormat + 1);
  EXPECT_EQ(Refusal(), path + ": " + unknown + ", this build reads formats 1 to " + known +
                           "; use a build that knows it");
  request_.resume = false;
  request_.config.mutable_policy()->set_initial_weights(path);
  EXPECT_NE(Refusal().find("--from " + path + ": " + unknown), std::string::npos) << Refusal();
}

TEST_F(RunStartTest, AnotherAlgorithmsWeightsAreNotBegunWith) {
  checkpoint::Checkpoint other = At(2);
  other.state.algorithm = {"other", 1, ""};
  request_.config.mutable_policy()->set_initial_weights(
      checkpoint::CheckpointStore(Checkpoints(), 5).Save(other));
  EXPECT_NE(Refusal().find("its algorithm is other, this run's is ppo"), std::string::npos)
      << Refusal();
}

TEST_F(RunStartTest, ACheckpointRemembersTheWeightsThatItsRunBeganWith) {
  checkpoint::Checkpoint checkpoint = At(1);
  checkpoint.initial_weights_sha256 = "00ff";
  EXPECT_EQ(
      checkpoint::DecodeCheckpoint(checkpoint::EncodeCheckpoint(checkpoint), "x", test::Describe)
          .initial_weights_sha256,
      "00ff");
}

}  // namespace
}  // namespace metronome::run
