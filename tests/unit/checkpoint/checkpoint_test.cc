#include "common/checkpoint/checkpoint.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <numeric>
#include <system_error>

#include "common/checkpoint/old_config.h"
#include "common/config/config.h"
#include "common/policy/network.h"
#include "common/policy/snapshot.h"
#include "common/process/files.h"
#include "common/process/sha256.h"
#include "common/schema/checkpoint.pb.h"
#include "tests/unit/support/environments.h"
#include "tests/unit/support/temporary_folder.h"

namespace metronome::checkpoint {
namespace {

namespace fs = std::filesystem;

/// A state whose every number differs from its neighbours and needs all its bits.
Checkpoint SmallCheckpoint(std::uint64_t version = 7) {
  Checkpoint checkpoint;
  test::SetTask(checkpoint.config, "push");
  config::SetField(checkpoint.config, "policy.hidden", "2");
  config::SetField(checkpoint.config, "policy.heads", "2");
  checkpoint.config = config::Resolve(checkpoint.config);
  const policy::NetworkShape shape = policy::ShapeOf(checkpoint.config);
  TrainState& state = checkpoint.state;
  state.version = version;
  state.steps = version * 8000;
  state.policy.version = version;
  state.policy.parameters.resize(policy::ActorLayout(shape).size);
  std::iota(state.policy.parameters.begin(), state.policy.parameters.end(), 0.1F);
  state.policy.parameters[0] = std::numeric_limits<float>::denorm_min();
  state.policy.parameters[1] = -0.0F;
  state.policy.observation_mean.assign(39, 1.0F / 3);
  state.policy.observation_inv_std.assign(39, 1.0e-30F);
  state.weights = {policy::ParameterCount(shape), "00aa"};
  state.algorithm = {"any", 9, std::string("\0 opaque \xff", 10)};
  state.canonical_digest = "00ff";
  state.episodes_used = version * 16;
  checkpoint.engine = "mujoco-2.2.2";
  checkpoint.build = "a build";
  checkpoint.isa = "avx2";
  checkpoint.incarnation = 3;
  checkpoint.logs = {1234, 5678, 90.5};
  return checkpoint;
}

std::string ErrorOfDecoding(const std::string& bytes) {
  try {
    static_cast<void>(DecodeCheckpoint(bytes, "x.ckpt", test::Describe));
  } catch (const CheckpointError& error) {
    return error.what();
  }
  return "";
}

/// A whole file around a payload.
std::string Framed(const std::string& payload, std::uint32_t format) {
  const auto length = static_cast<std::uint64_t>(payload.size());
  std::string head = "METRCKPT" + std::string(12, '\0');
  std::memcpy(head.data() + 8, &format, sizeof(format));
  std::memcpy(head.data() + 12, &length, sizeof(length));
  const process::Sha256Digest digest = process::Sha256(head + payload);
  return head + std::string(digest.begin(), digest.end()) + payload;
}

/// The bytes of a valid frame around the checkpoint with another format number.
std::string WithFormat(const Checkpoint& checkpoint, std::uint32_t format) {
  return Framed(EncodeCheckpoint(checkpoint).substr(52), format);
}

/// The state that formats 1 to 5 kept of a run of the configuration.
StateOfFormat5 OldState(const RunConfig& config) {
  StateOfFormat5 state;
  state.set_version(7);
  state.set_steps(56000);
  state.set_episodes_used(112);
  for (std::size_t i = 0; i < policy::ParameterCount(policy::ShapeOf(config)); ++i) {
    state.add_parameters(0.5F + float(i));
  }
  for (int i = 0; i < 39; ++i) {
    state.mutable_observation()->add_mean(i);
    state.mutable_observation()->add_m2(4.0 * i);
  }
  state.mutable_observation()->set_count(4);
  return state;
}

std::string OldFile(const RunConfig& config, const StateOfFormat5& state, std::uint32_t format) {
  CheckpointPayload payload;
  *payload.mutable_config() = config;
  payload.set_state_of_format_5(state.SerializeAsString());
  payload.set_engine("mujoco-2.2.2");
  return Framed(payload.SerializeAsString(), format);
}

TEST(Sha256Test, MatchesThePublishedVectors) {
  EXPECT_EQ(process::Sha256Hex(""),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(process::Sha256Hex("abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Sha256Test, WeightsAreHashedAsLittleEndianFloat32) {
  const std::string bytes("\x00\x00\x80\x3f\x00\x00\x00\xc0", 8);  // 1, -2
  EXPECT_EQ(process::WeightsSha256({1.0F, -2.0F}), process::Sha256Hex(bytes));
  EXPECT_NE(process::WeightsSha256({0.0F}), process::WeightsSha256({-0.0F}));
}

TEST(CheckpointTest, EveryBitComesBack) {
  const Checkpoint saved = SmallCheckpoint();
  const Checkpoint loaded = DecodeCheckpoint(EncodeCheckpoint(saved), "x.ckpt", test::Describe);
  EXPECT_EQ(loaded.state, saved.state);
  EXPECT_EQ(loaded.config.SerializeAsString(), saved.config.SerializeAsString());
  EXPECT_EQ(loaded.engine, saved.engine);
  EXPECT_EQ(loaded.build, saved.build);
  EXPECT_EQ(loaded.isa, saved.isa);
  EXPECT_EQ(loaded.incarnation, saved.incarnation);
  EXPECT_EQ(loaded.logs, saved.logs);
  EXPECT_EQ(EncodeCheckpoint(loaded), EncodeCheckpoint(saved));
}

TEST(CheckpointTest, AChangeOfAnyByteIsFoundAndNamesTheFile) {
  const std::string bytes = EncodeCheckpoint(SmallCheckpoint());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (const int flip : {0x01, 0x80, 0xff}) {
      std::string damaged = bytes;
      damaged[i] = static_cast<char>(damaged[i] ^ flip);
      ASSERT_TRUE(ErrorOfDecoding(damaged).starts_with("x.ckpt: ")) << "byte " << i;
    }
  }
}

TEST(CheckpointTest, EveryTruncationAndTrailingBytesAreFound) {
  const std::string bytes = EncodeCheckpoint(SmallCheckpoint());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    ASSERT_TRUE(ErrorOfDecoding(bytes.substr(0, size)).starts_with("x.ckpt: ")) << size;
  }
  EXPECT_NE(ErrorOfDecoding(bytes + '\0').find("damaged: it should hold"), std::string::npos);
  EXPECT_NE(ErrorOfDecoding(bytes.substr(0, 100)).find("damaged: it should hold"),
            std::string::npos);
}

TEST(CheckpointTest, AnotherFormatSaysWhich) {
  EXPECT_EQ(ErrorOfDecoding(WithFormat(SmallCheckpoint(), kCheckpointFormat)), "");
  for (const std::uint32_t format : {0U, kCheckpointFormat + 1}) {
    EXPECT_EQ(ErrorOfDecoding(WithFormat(SmallCheckpoint(), format)),
              "x.ckpt: checkpoint format " + std::to_string(format) +
                  ", this build reads formats 1 to 8; use a build that knows it");
  }
}

// What actors of this build bring is not what those of its build brought.
TEST(CheckpointTest, TheCanonicalDigestOfAnOlderBuildsNumbersIsNotRead) {
  const auto digest = [](std::uint32_t format) {
    const std::string bytes = WithFormat(SmallCheckpoint(), format);
    return DecodeCheckpoint(bytes, "x.ckpt", test::Describe).state.canonical_digest;
  };
  EXPECT_EQ(digest(6), "");
  EXPECT_EQ(digest(7), "00ff");
}

// PPO was the only algorithm, and its state, as it lies in the file, is its own format 1.
TEST(CheckpointTest, AFileOfFormat5HoldsThePolicyAndTheStateOfPpo) {
  const RunConfig config = SmallCheckpoint().config;
  const StateOfFormat5 old = OldState(config);
  const TrainState state =
      DecodeCheckpoint(OldFile(config, old, 5), "x.ckpt", test::Describe).state;
  EXPECT_EQ(state.version, 7U);
  EXPECT_EQ(state.steps, 56000U);
  EXPECT_EQ(state.episodes_used, 112U);
  EXPECT_EQ(state.algorithm, (AlgorithmState{"ppo", 1, old.SerializeAsString()}));
  const std::vector<float> all(old.parameters().begin(), old.parameters().end());
  EXPECT_EQ(state.weights, (WeightsDigest{all.size(), process::WeightsSha256(all)}));
  EXPECT_EQ(state.policy.version, 7U);
  const auto actor = std::ptrdiff_t(policy::ActorLayout(policy::ShapeOf(config)).size);
  EXPECT_EQ(state.policy.parameters, std::vector<float>(all.begin(), all.begin() + actor));
  EXPECT_EQ(state.policy.observation_mean[3], 3);
  EXPECT_FLOAT_EQ(state.policy.observation_inv_std[4], 0.5F);
}

TEST(CheckpointTest, AnOldFileWhoseStateDoesNotFitItsConfigurationIsRefused) {
  const RunConfig config = SmallCheckpoint().config;
  StateOfFormat5 old = OldState(config);
  old.mutable_parameters()->RemoveLast();
  EXPECT_NE(ErrorOfDecoding(OldFile(config, old, 5)).find("another shape: the network has"),
            std::string::npos);
  old = OldState(config);
  old.mutable_observation()->mutable_m2()->RemoveLast();
  EXPECT_NE(ErrorOfDecoding(OldFile(config, old, 5)).find("the observation statistics has 38"),
            std::string::npos);
}

void ExpectToGoOnAs(const RunConfig& whole, const RunConfig& old, std::uint32_t format) {
  const Checkpoint loaded =
      DecodeCheckpoint(OldFile(old, OldState(whole), format), "x.ckpt", test::Describe);
  EXPECT_EQ(loaded.state,
            DecodeCheckpoint(OldFile(whole, OldState(whole), 5), "x.ckpt", test::Describe).state);
  EXPECT_NO_THROW(RequireShape(loaded, whole, "x.ckpt"));
  EXPECT_TRUE(config::CompareForResume(loaded.config, whole, false).empty());
  EXPECT_EQ(config::Resolve(loaded.config).SerializeAsString(), whole.SerializeAsString());
}

/// A whole configuration of a run of format 7, whose defaults were other ones.
RunConfig WholeOldConfig() {
  RunConfig config = SmallCheckpoint().config;
  config.mutable_environment()->clear_reward();
  config.mutable_environment()->clear_success_reward();
  config.mutable_policy()->clear_noise_correlation();
  config.mutable_policy()->clear_critic_time();
  config.mutable_ppo()->clear_shared_heads();
  config.mutable_ppo()->clear_min_std();
  config.mutable_ppo()->clear_std_decay();
  config.mutable_ppo()->clear_log_std_rate();
  config.mutable_ppo()->clear_reward_scale_decay();
  config.mutable_ppo()->clear_success_weight();
  config.mutable_ppo()->clear_earlier_batches();
  CompleteOldConfig(config);
  return config::Resolve(config);
}

// Old files are without what their format did not know.
TEST(CheckpointTest, AFileOfFormat5IsDescribedByWhoKnowsItsEnvironment) {
  const RunConfig whole = WholeOldConfig();
  RunConfig old = whole;
  old.mutable_environment()->clear_spec();
  ExpectToGoOnAs(whole, old, 5);
  old.mutable_environment()->set_task("pull");
  EXPECT_EQ(ErrorOfDecoding(OldFile(old, OldState(whole), 5)),
            "x.ckpt: environment.task is an unknown environment \"pull\"; Known: assembly, "
            "box-close, push");
}

TEST(CheckpointTest, AFileOfFormat3GoesOnWithTheOfficialReward) {
  const RunConfig whole = WholeOldConfig();
  RunConfig old = whole;
  old.mutable_environment()->clear_spec();
  old.mutable_environment()->clear_reward();
  ExpectToGoOnAs(whole, old, 3);
}

TEST(CheckpointTest, AFileOfFormat2GoesOnWithWhiteNoise) {
  const RunConfig whole = WholeOldConfig();
  RunConfig old = whole;
  old.mutable_environment()->clear_spec();
  old.mutable_environment()->clear_reward();
  old.mutable_policy()->clear_noise_correlation();
  ExpectToGoOnAs(whole, old, 2);
}

TEST(CheckpointTest, AFileOfFormat1GoesOnAsBlocksWithSeparateCriticHeads) {
  const RunConfig whole = WholeOldConfig();
  RunConfig old = whole;
  old.mutable_environment()->clear_spec();
  old.mutable_policy()->clear_schedule();
  old.mutable_policy()->clear_critic_heads();
  old.mutable_policy()->clear_noise_correlation();
  old.mutable_environment()->clear_reward();
  ExpectToGoOnAs(whole, old, 1);
}

TEST(CheckpointTest, AFileOfFormat7GoesOnWithTheRewardOfItsSuccess) {
  RunConfig whole = WholeOldConfig();
  whole.mutable_environment()->set_reward(REWARD_SUCCESS);
  whole.mutable_environment()->set_success_reward(12.5);
  RunConfig old = whole;
  old.mutable_environment()->clear_spec();
  old.mutable_environment()->clear_reward();
  old.mutable_environment()->clear_success_reward();
  ConfigOfFormat7 rewarded;
  rewarded.mutable_ppo()->set_success_reward(12.5);
  old.MergeFromString(rewarded.SerializeAsString());
  ExpectToGoOnAs(whole, old, 5);
}

TEST(CheckpointTest, AFileOfFormat7HasNothingThatCameAfterIt) {
  const RunConfig whole = WholeOldConfig();
  EXPECT_EQ(whole.environment().reward(), REWARD_OFFICIAL);
  EXPECT_EQ(whole.policy().noise_correlation(), 0);
  EXPECT_FALSE(whole.policy().critic_time());
  EXPECT_FALSE(whole.ppo().shared_heads());
  EXPECT_EQ(whole.ppo().min_std(), 0);
  EXPECT_EQ(whole.ppo().std_decay(), 0);
  EXPECT_EQ(whole.ppo().log_std_rate(), 1);
  EXPECT_EQ(whole.ppo().reward_scale_decay(), 1);
  EXPECT_EQ(whole.ppo().success_weight(), 0);
  EXPECT_EQ(whole.ppo().earlier_batches(), 0);
  RunConfig old = whole;
  old.mutable_environment()->clear_reward();
  old.mutable_policy()->clear_critic_time();
  old.mutable_ppo()->clear_shared_heads();
  old.mutable_ppo()->clear_min_std();
  old.mutable_ppo()->clear_std_decay();
  old.mutable_ppo()->clear_log_std_rate();
  old.mutable_ppo()->clear_reward_scale_decay();
  old.mutable_ppo()->clear_success_weight();
  old.mutable_ppo()->clear_earlier_batches();
  Checkpoint checkpoint = SmallCheckpoint();
  checkpoint.config = old;
  const Checkpoint loaded = DecodeCheckpoint(WithFormat(checkpoint, 7), "x.ckpt", test::Describe);
  EXPECT_TRUE(config::CompareForResume(config::Resolve(loaded.config), whole, false).empty());
}

TEST(CheckpointTest, AFileOfFormat7OfAnotherAlgorithmHasTheOfficialRewardToo) {
  RunConfig old;
  old.mutable_custom()->set_name("other");
  CompleteOldConfig(old);
  EXPECT_TRUE(old.environment().has_reward());
  EXPECT_EQ(old.environment().reward(), REWARD_OFFICIAL);
  EXPECT_TRUE(old.has_custom());
}

// Written by builds of formats 4 and before, and not to be written again.
TEST(CheckpointTest, TheCommittedPoliciesLoadWithTheirWeights) {
  const std::string folder = METRONOME_SOURCE_DIR "/results/policies/";
  const std::map<std::string, std::string> weights = {
      {"assembly", "ad9145d97dce3766544a74c36fa9a235e20e02c54f625d56c622270f1dc03d93"},
      {"bin-picking", "c62977aeb2240d48cdef5e5e15800c9ede42dbe168dcf64d332b26a3ed878774"},
      {"box-close", "9231382043e0753a83a40a50e6bea2857613fc09d04061e9322b66812584a8b5"},
      {"push", "c24b665a1af3d17c5901dc96d82ff520ac3c4d7c363d2ac7f65f72b4cf2850ac"}};
  for (const auto& [task, sha256] : weights) {
    const Checkpoint checkpoint = LoadCheckpoint(folder + task + ".ckpt", test::SpecOf);
    EXPECT_EQ(checkpoint.state.weights.sha256, sha256) << task;
    EXPECT_EQ(policy::SnapshotDefect(checkpoint.state.policy, checkpoint.config), std::nullopt)
        << task;
  }
}

TEST(CheckpointTest, SomethingElseAltogetherIsSaidToBe) {
  EXPECT_NE(ErrorOfDecoding("").find("not a Metronome checkpoint"), std::string::npos);
  EXPECT_NE(ErrorOfDecoding(std::string(1000, 'x')).find("not a Metronome checkpoint"),
            std::string::npos);
}

TEST(CheckpointTest, StateThatDoesNotFitItsConfigurationIsRefused) {
  Checkpoint checkpoint = SmallCheckpoint();
  checkpoint.config.mutable_policy()->set_heads(3);
  EXPECT_NE(ErrorOfDecoding(EncodeCheckpoint(checkpoint)).find("another shape: the policy has"),
            std::string::npos);
  checkpoint = SmallCheckpoint();
  checkpoint.state.policy.observation_inv_std.pop_back();
  EXPECT_NE(ErrorOfDecoding(EncodeCheckpoint(checkpoint)).find("the observations' scale has 38"),
            std::string::npos);
  checkpoint = SmallCheckpoint();
  checkpoint.config.mutable_policy()->set_heads(0);
  EXPECT_NE(ErrorOfDecoding(EncodeCheckpoint(checkpoint)).find("policy.heads is 0"),
            std::string::npos);
}

TEST(CheckpointTest, AnotherNetworkShapeNamesBoth) {
  const Checkpoint checkpoint = SmallCheckpoint();
  EXPECT_NO_THROW(RequireShape(checkpoint, checkpoint.config, "x.ckpt"));
  RunConfig other = checkpoint.config;
  config::SetField(other, "policy.hidden", "2,4");
  config::SetField(other, "policy.critic_heads", "shared");
  try {
    RequireShape(checkpoint, other, "x.ckpt");
    FAIL();
  } catch (const CheckpointError& error) {
    EXPECT_STREQ(
        error.what(),
        "x.ckpt: another network shape: it holds 39 inputs, hidden 2, 2 heads of 4, 2 of the "
        "critic of 1 value; asked for is 39 inputs, hidden 2 4, 2 heads of 4, 1 of the critic of "
        "1 value");
  }
}

TEST(CheckpointTest, UnreadableFilesAreNamed) {
  for (const std::string path : {"no/such.ckpt", "."}) {
    try {
      static_cast<void>(LoadCheckpoint(path, test::Describe));
      FAIL() << path;
    } catch (const CheckpointError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with("cannot read checkpoint " + path + ": "));
    }
  }
}

class CheckpointStoreTest : public TemporaryFolderTest {
 protected:
  [[nodiscard]] std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  const std::string folder_ = root_ + "/checkpoints";
};

TEST_F(CheckpointStoreTest, AnEmptyFolderHasNoLatest) {
  EXPECT_EQ(CheckpointStore(folder_, 5).Latest(), std::nullopt);
}

TEST_F(CheckpointStoreTest, SavesUnderTheVersionAndPointsLatestAtIt) {
  CheckpointStore store(folder_, 5);
  EXPECT_EQ(store.Save(SmallCheckpoint(123)), folder_ + "/000123.ckpt");
  EXPECT_EQ(Names(), (std::vector<std::string>{"000123.ckpt", "latest"}));
  EXPECT_EQ(fs::read_symlink(folder_ + "/latest"), "000123.ckpt");
  EXPECT_EQ(store.Latest(), folder_ + "/000123.ckpt");
  EXPECT_EQ(LoadCheckpoint(folder_ + "/latest", test::Describe).state, SmallCheckpoint(123).state);
}

TEST_F(CheckpointStoreTest, PrunesToTheNewest) {
  CheckpointStore store(folder_, 2);
  for (std::uint64_t version = 999998; version <= 1000001; ++version) {
    store.Save(SmallCheckpoint(version));
  }
  EXPECT_EQ(Names(), (std::vector<std::string>{"1000000.ckpt", "1000001.ckpt", "latest"}));
}

TEST_F(CheckpointStoreTest, KeepsMilestonesBesideTheNewest) {
  CheckpointStore store(folder_, 2, 4);
  for (std::uint64_t version = 3; version <= 11; ++version) store.Save(SmallCheckpoint(version));
  EXPECT_EQ(Names(), (std::vector<std::string>{"000004.ckpt", "000008.ckpt", "000010.ckpt",
                                               "000011.ckpt", "latest"}));
}

TEST_F(CheckpointStoreTest, NeverPrunesWhatLatestNames) {
  CheckpointStore store(folder_, 2);
  for (std::uint64_t version = 5; version <= 6; ++version) store.Save(SmallCheckpoint(version));
  store.Save(SmallCheckpoint(1));  // a run that was set back to an older checkpoint
  EXPECT_EQ(store.Latest(), folder_ + "/000001.ckpt");
  EXPECT_TRUE(fs::exists(folder_ + "/000001.ckpt"));
}

TEST_F(CheckpointStoreTest, WithoutTheLinkTheHighestVersionIsLatest) {
  CheckpointStore store(folder_, 5);
  store.Save(SmallCheckpoint(9));
  store.Save(SmallCheckpoint(10));
  fs::remove(folder_ + "/latest");
  EXPECT_EQ(store.Latest(), folder_ + "/000010.ckpt");
}

TEST_F(CheckpointStoreTest, RemovesWhatAKilledWriterLeft) {
  CheckpointStore(folder_, 5).Save(SmallCheckpoint(1));
  std::ofstream(folder_ + "/000002.ckpt.tmp.4711") << "half";
  EXPECT_EQ(CheckpointStore(folder_, 5).Latest(), folder_ + "/000001.ckpt");
  EXPECT_EQ(Names(), (std::vector<std::string>{"000001.ckpt", "latest"}));
}

TEST_F(CheckpointStoreTest, ARunThatWasSetBackKeepsWhatLiesAheadAndItsOwnNewest) {
  CheckpointStore store(folder_, 2);
  for (std::uint64_t version = 5; version <= 6; ++version) store.Save(SmallCheckpoint(version));
  for (std::uint64_t version = 1; version <= 3; ++version) store.Save(SmallCheckpoint(version));
  EXPECT_EQ(Names(), (std::vector<std::string>{"000002.ckpt", "000003.ckpt", "000005.ckpt",
                                               "000006.ckpt", "latest"}));
}

/// A folder with versions 1 to 4, `latest` naming the last.
class NewestCheckpointTest : public CheckpointStoreTest {
 protected:
  NewestCheckpointTest() {
    for (std::uint64_t version = 1; version <= 4; ++version) store_.Save(SmallCheckpoint(version));
  }

  [[nodiscard]] std::string Path(const std::string& name) const { return folder_ + "/" + name; }

  void Write(const std::string& name, const std::string& content) const {
    std::ofstream(Path(name), std::ios::binary | std::ios::trunc) << content;
  }

  void PointLatestAt(const std::string& target) const {
    fs::remove_all(Path("latest"));
    fs::create_symlink(target, Path("latest"));
  }

  /// Goes on from what is found. @return its version.
  std::uint64_t GoOn() {
    const auto found = FindNewestCheckpoint(folder_, test::Describe);
    if (!found) return 0;
    store_.GoOnFrom(*found);
    passed_over_ = found->passed_over.size();
    return found->checkpoint.state.version;
  }

  [[nodiscard]] std::string Refusal() const {
    try {
      static_cast<void>(FindNewestCheckpoint(folder_, test::Describe));
    } catch (const CheckpointError& error) {
      return error.what();
    }
    return "none";
  }

  CheckpointStore store_{folder_, 5};
  std::size_t passed_over_ = 0;
};

TEST_F(NewestCheckpointTest, LatestIsObeyedAlsoWhereItNamesAnOlderOne) {
  EXPECT_EQ(GoOn(), 4U);
  PointLatestAt("000002.ckpt");
  EXPECT_EQ(GoOn(), 2U);
  EXPECT_EQ(passed_over_, 0U);
  EXPECT_EQ(fs::read_symlink(Path("latest")), "000002.ckpt");
}

TEST_F(NewestCheckpointTest, ADamagedOneIsPutAsideAndTheOneBeforeItIsTaken) {
  const std::string whole = process::ReadFile(Path("000004.ckpt"));
  std::string flipped = whole;
  flipped[whole.size() / 2] ^= 1;
  for (const std::string& content : {std::string(), whole.substr(0, 20), whole.substr(0, 1000),
                                     flipped, std::string(whole.size(), '\0')}) {
    Write("000004.ckpt", content);
    PointLatestAt("000004.ckpt");
    EXPECT_EQ(GoOn(), 3U) << content.size();
    EXPECT_EQ(passed_over_, 1U);
    EXPECT_EQ(fs::read_symlink(Path("latest")), "000003.ckpt");
    EXPECT_FALSE(fs::exists(Path("000004.ckpt")));
    EXPECT_EQ(process::ReadFile(Path("000004.ckpt.damaged")), content);
    fs::remove(Path("000004.ckpt.damaged"));
  }
}

TEST_F(NewestCheckpointTest, ADamagedOneIsPutAsideHoweverLatestNamesIt) {
  Write("000004.ckpt", "");
  PointLatestAt(fs::absolute(folder_).string() + "/../checkpoints/000004.ckpt");
  EXPECT_EQ(GoOn(), 3U);
  EXPECT_TRUE(fs::exists(Path("000004.ckpt.damaged")));
}

TEST_F(NewestCheckpointTest, WhereLatestLeadsElsewhereTheFolderHasItsOwnOfThatVersion) {
  fs::create_directory(root_ + "/elsewhere");
  const std::string foreign = fs::absolute(root_).string() + "/elsewhere/000004.ckpt";
  std::ofstream(foreign) << "damaged";
  PointLatestAt(foreign);
  EXPECT_EQ(GoOn(), 4U);
  EXPECT_EQ(fs::read_symlink(Path("latest")), "000004.ckpt");
  EXPECT_TRUE(fs::exists(foreign)) << "it is not ours";
}

TEST_F(NewestCheckpointTest, NothingThatWasPutAsideIsWrittenOver) {
  for (const std::string content : {"one", "two"}) {
    Write("000004.ckpt", content);
    EXPECT_EQ(GoOn(), 3U);
    PointLatestAt("000004.ckpt");
  }
  EXPECT_EQ(process::ReadFile(Path("000004.ckpt.damaged")), "one");
  EXPECT_EQ(process::ReadFile(Path("000004.ckpt.2.damaged")), "two");
}

TEST_F(NewestCheckpointTest, PruningCountsGoodOnesAlone) {
  for (const std::string name : {"000003.ckpt", "000004.ckpt"}) Write(name, "");
  EXPECT_EQ(GoOn(), 2U);
  CheckpointStore(folder_, 2).Save(SmallCheckpoint(3));
  EXPECT_EQ(Names(), (std::vector<std::string>{"000002.ckpt", "000003.ckpt", "000003.ckpt.damaged",
                                               "000004.ckpt.damaged", "latest"}));
}

TEST_F(NewestCheckpointTest, ALinkThatLeadsNowhereGivesTheNewestUpToIt) {
  fs::remove(Path("000003.ckpt"));
  PointLatestAt("000003.ckpt");
  EXPECT_EQ(GoOn(), 2U);
  EXPECT_EQ(fs::read_symlink(Path("latest")), "000002.ckpt") << "evaluate finds it again";
  for (const std::string target : {"000000.ckpt", "nowhere", "latest"}) {
    PointLatestAt(target);
    EXPECT_EQ(GoOn(), 4U) << target;
    EXPECT_EQ(fs::read_symlink(Path("latest")), "000004.ckpt");
  }
}

TEST_F(NewestCheckpointTest, WithoutTheLinkTheNewestIsTaken) {
  fs::remove(Path("latest"));
  EXPECT_EQ(GoOn(), 4U);
  Write("000004.ckpt", "");
  EXPECT_EQ(GoOn(), 3U);
}

TEST_F(NewestCheckpointTest, AFileInPlaceOfTheLinkIsACopyOfACheckpoint) {
  fs::remove(Path("latest"));
  fs::copy_file(Path("000003.ckpt"), Path("latest"));
  EXPECT_EQ(GoOn(), 3U);
  Write("latest", "000004.ckpt");  // as archives without links hold it
  EXPECT_EQ(GoOn(), 4U);
  EXPECT_EQ(fs::read_symlink(Path("latest")), "000004.ckpt");
}

TEST_F(NewestCheckpointTest, AFolderInPlaceOfTheLinkOrOfAFileIsPutAside) {
  fs::remove(Path("latest"));
  fs::create_directory(Path("latest"));
  fs::remove(Path("000004.ckpt"));
  fs::create_directory(Path("000004.ckpt"));
  EXPECT_EQ(GoOn(), 3U);
  store_.Save(SmallCheckpoint(4));
  EXPECT_EQ(GoOn(), 4U);
}

TEST_F(NewestCheckpointTest, WhatIsNotOfTheRunIsNotMoved) {
  const std::string elsewhere = root_ + "/copy.ckpt";
  std::ofstream(elsewhere) << "no checkpoint";
  PointLatestAt(elsewhere);
  EXPECT_EQ(GoOn(), 4U);
  EXPECT_TRUE(fs::exists(elsewhere));
}

TEST_F(NewestCheckpointTest, ANewerFormatIsNotPassedOverButNamedWithTheWayBack) {
  Write("000004.ckpt", WithFormat(SmallCheckpoint(4), kCheckpointFormat + 1));
  const std::string text = Refusal();
  EXPECT_NE(text.find("000004.ckpt: checkpoint format " + std::to_string(kCheckpointFormat + 1) +
                      ", this build reads"),
            std::string::npos);
  EXPECT_NE(text.find("ln -sfn 000003.ckpt '" + Path("latest") + "'"), std::string::npos) << text;
}

TEST_F(NewestCheckpointTest, WhatCannotBeReadIsNotTakenForDamaged) {
  fs::remove(Path("000004.ckpt"));
  fs::create_symlink("/proc/self/mem", Path("000004.ckpt"));  // reading it fails, whoever asks
  EXPECT_THROW(FindNewestCheckpoint(folder_, test::Describe), CheckpointUnreadable);
  EXPECT_NE(Refusal().find("Input/output error; or go back to"), std::string::npos) << Refusal();
}

TEST_F(NewestCheckpointTest, WithoutAWholeOneEachIsNamed) {
  for (const std::string name : {"000001.ckpt", "000002.ckpt", "000003.ckpt", "000004.ckpt"}) {
    Write(name, "");
  }
  const std::string text = Refusal();
  for (const std::string word : {"000001.ckpt: ", "000004.ckpt: ", "another --run"}) {
    EXPECT_NE(text.find(word), std::string::npos) << text;
  }
}

TEST_F(NewestCheckpointTest, OnlyAFolderWithoutATraceOfOneHasNone) {
  for (const std::string name : {"000001.ckpt", "000002.ckpt", "000003.ckpt", "000004.ckpt"}) {
    fs::remove(Path(name));
  }
  EXPECT_NE(Refusal().find("000004.ckpt: missing"), std::string::npos) << Refusal();
  fs::remove(Path("latest"));
  EXPECT_EQ(FindNewestCheckpoint(folder_, test::Describe), std::nullopt);
  Write("000004.ckpt.damaged", "");
  EXPECT_NE(Refusal().find("000004.ckpt.damaged"), std::string::npos) << Refusal();
  EXPECT_EQ(FindNewestCheckpoint(root_ + "/no such folder", test::Describe), std::nullopt);
}

TEST_F(NewestCheckpointTest, ReadingWhatIsNotThereNamesWhatIs) {
  PointLatestAt("000009.ckpt");
  for (const std::string& path : {Path("latest"), Path("000009.ckpt"), root_}) {
    try {
      static_cast<void>(LoadCheckpoint(path, test::Describe));
      FAIL() << path;
    } catch (const CheckpointUnreadable& error) {
      const std::string text = error.what();
      EXPECT_NE(text.find("there are 000004.ckpt, 000003.ckpt"), std::string::npos) << text;
      EXPECT_EQ(text.find("leads to 000009.ckpt") != std::string::npos, path == Path("latest"));
    }
  }
  Write("000004.ckpt", "");
  EXPECT_THROW(LoadCheckpoint(Path("000004.ckpt"), test::Describe), CheckpointDamaged);
}

/// Saves in a child in which no file may grow past 1000 bytes (the limit cannot be raised again).
/// @return whether it failed with an error that names the file.
bool SaveFailsOnAFullDisk(CheckpointStore& store, const Checkpoint& checkpoint,
                          const std::string& file) {
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1000, 1000};
    setrlimit(RLIMIT_FSIZE, &limit);
    try {
      store.Save(checkpoint);
    } catch (const std::system_error& error) {
      const bool named = std::string(error.what()).find(file) != std::string::npos;
      _exit(named && error.code() == std::errc::file_too_large ? 0 : 2);
    }
    _exit(1);
  }
  int status = -1;
  return waitpid(child, &status, 0) == child && status == 0;
}

TEST_F(CheckpointStoreTest, AFullDiskLeavesTheOldCheckpointAndNoRest) {
  CheckpointStore store(folder_, 5);
  store.Save(SmallCheckpoint(1));
  const std::string before = process::ReadFile(folder_ + "/latest");
  EXPECT_TRUE(SaveFailsOnAFullDisk(store, SmallCheckpoint(2), "000002.ckpt"));
  EXPECT_TRUE(SaveFailsOnAFullDisk(store, SmallCheckpoint(1), "000001.ckpt"));
  EXPECT_EQ(Names(), (std::vector<std::string>{"000001.ckpt", "latest"}));
  EXPECT_EQ(process::ReadFile(folder_ + "/latest"), before);
}

TEST_F(CheckpointStoreTest, AFolderThatCannotBeWrittenLeavesTheOldCheckpoint) {
  CheckpointStore store(folder_, 5);
  store.Save(SmallCheckpoint(1));
  fs::create_directory(folder_ + "/000002.ckpt");  // rename cannot replace a folder
  EXPECT_THROW(store.Save(SmallCheckpoint(2)), std::system_error);
  EXPECT_EQ(store.Latest(), folder_ + "/000001.ckpt");
  EXPECT_EQ(Names(), (std::vector<std::string>{"000001.ckpt", "000002.ckpt", "latest"}));
}

class FilesTest : public TemporaryFolderTest {
 protected:
  /// The reason why the path cannot be written.
  static std::string Refusal(const fs::path& path) {
    try {
      process::WriteFileAtomically(path, "new");
    } catch (const std::system_error& error) {
      return error.what();
    }
    return "none";
  }

  const fs::path folder_ = root_;
};

TEST_F(FilesTest, WhatIsNoRegularFileIsNotReplaced) {
  // As /dev/null and /dev/stdout are for root.
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const fs::path link = folder_ / "link";
  fs::create_symlink("pipe", link);
  for (const fs::path& path : {pipe, link, folder_}) {
    EXPECT_NE(Refusal(path).find("cannot write " + path.string()), std::string::npos)
        << Refusal(path);
  }
  EXPECT_TRUE(fs::is_fifo(pipe));
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 2) << "something is left over";
}

TEST_F(FilesTest, AProcessThatIsKilledAmidWritingLeavesTheOldContentAndNothingElse) {
  const fs::path file = folder_ / "file";
  for (const bool there : {false, true}) {
    if (there) std::ofstream(file) << "old";
    const pid_t child = fork();
    if (child == 0) {
      const rlimit limit{4096, 4096};  // the signal that tells of it ends the process
      setrlimit(RLIMIT_FSIZE, &limit);
      std::signal(SIGXFSZ, SIG_DFL);
      process::WriteFileAtomically(file, std::string(8192, 'n'));
      _exit(0);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status)) << status;
    EXPECT_EQ(fs::exists(file) ? process::ReadFile(file) : "none", there ? "old" : "none");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), there ? 1 : 0);
  }
}

TEST_F(FilesTest, AnOldFileIsReplaced) {
  const fs::path file = folder_ / "file";
  for (const char* content : {"first", "second"}) {
    process::WriteFileAtomically(file, content);
    EXPECT_EQ(process::ReadFile(file), content);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
  }
}

TEST_F(FilesTest, AFileIsWrittenThroughItsLink) {
  const fs::path file = folder_ / "file";
  const fs::path link = folder_ / "link";
  std::ofstream(file) << "old";
  fs::create_symlink("file", link);
  process::WriteFileAtomically(link, "new");
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(process::ReadFile(file), "new");
}

TEST_F(FilesTest, ALinkThatLeadsNowhereIsReplaced) {
  const fs::path link = folder_ / "link";
  fs::create_symlink("nowhere", link);
  process::WriteFileAtomically(link, "new");
  EXPECT_EQ(process::ReadFile(link), "new");
}

}  // namespace
}  // namespace metronome::checkpoint
