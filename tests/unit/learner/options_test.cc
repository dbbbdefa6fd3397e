#include "learner/options.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/checkpoint/checkpoint.h"
#include "common/config/config.h"
#include "common/kernels/isa.h"
#include "common/policy/network.h"
#include "common/process/sha256.h"
#include "learner/record/inspect.h"
#include "learner/record/run_folder.h"
#include "learner/run/initial_weights.h"
#include "tests/unit/support/environments.h"
#include "tests/unit/support/temporary_folder.h"

namespace metronome::learner {
namespace {

namespace fs = std::filesystem;

class OptionsTest : public TemporaryFolderTest {
 protected:
  /// Parses `metronome-learner ARGUMENTS`; what it prints goes to out_ and err_.
  std::variant<int, LearnerCommand> Parse(const std::vector<std::string>& arguments) {
    std::vector<const char*> argv = {"metronome-learner"};
    for (const auto& argument : arguments) argv.push_back(argument.c_str());
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    auto parsed = ParseLearnerCommand(static_cast<int>(argv.size()), argv.data(), test::Describe);
    out_ = ::testing::internal::GetCapturedStdout();
    err_ = ::testing::internal::GetCapturedStderr();
    return parsed;
  }

  /// Of `run --run demo --task TASK` in the test's own folder, with more.
  std::variant<int, LearnerCommand> ParseRun(std::vector<std::string> more) {
    more.insert(more.begin(), {"run", "--run", "demo", "--runs-dir", runs_, "--task", task_});
    return Parse(more);
  }

  RunOptions Run(const std::vector<std::string>& more) {
    const auto parsed = ParseRun(more);
    if (std::holds_alternative<int>(parsed)) {
      ADD_FAILURE() << err_;
      return {};
    }
    return std::get<RunOptions>(std::get<LearnerCommand>(parsed));
  }

  /// Expects exit status 2 and `text` on standard error.
  void ExpectUsageError(const std::variant<int, LearnerCommand>& parsed, const std::string& text) {
    ASSERT_TRUE(std::holds_alternative<int>(parsed)) << text;
    EXPECT_EQ(std::get<int>(parsed), 2);
    EXPECT_NE(err_.find(text), std::string::npos) << err_;
    EXPECT_EQ(out_, "");
  }

  void MakeRun(const RunConfig& config) {
    fs::create_directories(fs::path(runs_) / "demo");
    std::ofstream(record::ConfigPathOf((fs::path(runs_) / "demo").string()))
        << config::PrintConfig(config);
  }

  void SetTask(const std::string& task) { task_ = task; }

  std::string task_ = "push";
  const std::string runs_ = root_;
  std::string out_, err_;
};

TEST_F(OptionsTest, DefaultsAreThoseOfTheConfiguration) {
  const RunOptions options = Run({});
  EXPECT_EQ(options.run, "demo");
  EXPECT_EQ(options.folder, (fs::path(runs_) / "demo").string());
  EXPECT_FALSE(options.resume);
  EXPECT_EQ(options.progress, record::ProgressStyle::kLines);
  EXPECT_EQ(options.log.level, "info");
  EXPECT_EQ(options.log.format, "text");
  RunConfig expected;
  test::SetTask(expected, "push");
  EXPECT_EQ(options.config.SerializeAsString(), config::Resolve(expected).SerializeAsString());
}

TEST_F(OptionsTest, EveryOptionReachesItsField) {
  const RunConfig config = Run({"--method",
                                "ppo-time",
                                "--heads",
                                "1",
                                "--steps",
                                "99",
                                "--seed",
                                "18446744073709551615",
                                "--horizon",
                                "50",
                                "--placements",
                                "fixed",
                                "--goal",
                                "hidden",
                                "--domain",
                                "232",
                                "--transport",
                                "shm",
                                "--network",
                                "lan",
                                "--threads",
                                "3",
                                "--checkpoint-every",
                                "7",
                                "--metrics",
                                "0.0.0.0:9464",
                                "--progress",
                                "json",
                                "--log-level",
                                "debug",
                                "--set",
                                "ppo.clip=0.1",
                                "--set",
                                "policy.hidden=64,32"})
                               .config;
  EXPECT_EQ(config.policy().method(), SINGLE_TIME);
  EXPECT_EQ(config.policy().heads(), 1);
  EXPECT_EQ(config.total_steps(), 99u);
  EXPECT_EQ(config.seed(), 18446744073709551615u);
  EXPECT_EQ(config.environment().horizon(), 50);
  EXPECT_EQ(config.environment().placements(), PLACEMENTS_FIXED);
  EXPECT_FALSE(config.environment().goal_visible());
  EXPECT_EQ(config.runtime().domain(), 232u);
  EXPECT_EQ(config.runtime().transport(), "shm");
  EXPECT_EQ(config.runtime().network(), "lan");
  EXPECT_EQ(config.runtime().learner_threads(), 3);
  EXPECT_EQ(config.runtime().checkpoint_every(), 7);
  EXPECT_EQ(config.runtime().metrics(), "0.0.0.0:9464");
  EXPECT_EQ(config.ppo().clip(), 0.1);
  EXPECT_EQ(config.policy().hidden_size(), 2);
}

TEST_F(OptionsTest, InstructionsAreOfTheProcessAndNotOfTheRun) {
  const kernels::Isa before = kernels::CurrentIsa();
  const std::string config = Run({}).config.SerializeAsString();
  EXPECT_EQ(kernels::CurrentIsa(), before);
  EXPECT_EQ(Run({"--isa", "scalar"}).config.SerializeAsString(), config);
  EXPECT_EQ(kernels::CurrentIsa(), kernels::Isa::kScalar);
  kernels::ChooseIsa(before);
  ExpectUsageError(ParseRun({"--isa", "scaler"}),
                   "--isa: unknown instruction set \"scaler\"; did you mean \"scalar\"? Known: "
                   "scalar, avx2, avx512; this processor has: scalar");
  EXPECT_EQ(kernels::CurrentIsa(), before);
}

TEST_F(OptionsTest, FileYieldsToSetAndSetToOptions) {
  const std::string file = runs_ + "/run.cfg";
  std::ofstream(file) << "seed: 1\ntotal_steps: 1\nppo { clip: 0.1 }\n";
  const RunConfig config =
      Run({"--seed", "3", "--set", "seed=2", "--set", "total_steps=2", "--config", file}).config;
  EXPECT_EQ(config.seed(), 3u);
  EXPECT_EQ(config.total_steps(), 2u);
  EXPECT_EQ(config.ppo().clip(), 0.1);
}

TEST_F(OptionsTest, FilesYieldToLaterOnesAndToSetAndToOptions) {
  const std::string first = runs_ + "/first.cfg", second = runs_ + "/second.cfg";
  std::ofstream(first) << "seed: 1\ntotal_steps: 1\nppo { clip: 0.1\n discount: 0.9 }\n";
  std::ofstream(second) << "seed: 2\ntotal_steps: 2\nppo { clip: 0.2 }\n";
  const std::vector<std::string> options = {"--config", first,    "--steps",  "3",
                                            "--set",    "seed=3", "--config", second};
  std::vector<std::string> print = {"config", "--task", "push"};
  print.insert(print.end(), options.begin(), options.end());
  for (const RunConfig& config :
       {Run(options).config,
        std::get<PrintConfigOptions>(std::get<LearnerCommand>(Parse(print))).config}) {
    EXPECT_EQ(config.total_steps(), 3u);
    EXPECT_EQ(config.seed(), 3u);
    EXPECT_EQ(config.ppo().clip(), 0.2);
    EXPECT_EQ(config.ppo().discount(), 0.9);
  }
}

TEST_F(OptionsTest, AnOptionOfOneValueIsNotGivenTwice) {
  ExpectUsageError(
      ParseRun({"--heads", "3", "--heads", "4"}),
      "metronome-learner run: --heads is given 2 times, and it has one value: \"3\" or "
      "\"4\"?");
}

TEST_F(OptionsTest, UnknownNamesGetTheNearMissAndTheList) {
  ExpectUsageError(ParseRun({"--hedas", "3"}),
                   "unknown option \"--hedas\"; did you mean \"--heads\"?");
  ExpectUsageError(ParseRun({"--hedas=3"}),
                   "unknown option \"--hedas\"; did you mean \"--heads\"?");
  EXPECT_NE(err_.find("--checkpoint-every"), std::string::npos) << "the list is missing";
  ExpectUsageError(
      Parse({"rnu", "--run", "x"}),
      "unknown command \"rnu\"; did you mean \"run\"? Known: run, inspect, export, config");
  ExpectUsageError(Parse({"run", "--run", "x", "--task", "psuh"}),
                   "unknown environment \"psuh\"; Known: assembly");
  ExpectUsageError(ParseRun({"--method", "multihaed"}), "did you mean \"multihead\"?");
  ExpectUsageError(ParseRun({"--set", "ppo.learning_rte=1"}), "did you mean \"learning_rate\"?");
  ExpectUsageError(ParseRun({"--progress", "jason"}), "did you mean \"json\"?");
  ExpectUsageError(ParseRun({"--goal", "hiden"}), "did you mean \"hidden\"?");
  ExpectUsageError(ParseRun({"--log-level", "inof"}), "did you mean \"info\"?");
  ExpectUsageError(ParseRun({"--log-format", "jsno"}), "did you mean \"json\"?");
}

TEST_F(OptionsTest, CommandLinesThatMakeNoSenseAreNamed) {
  ExpectUsageError(Parse({}), "name a command: run, inspect, export, config");
  ExpectUsageError(Parse({"run", "--task", "push"}), "--run NAME is needed");
  ExpectUsageError(Parse({"run", "--run", "x"}), "environment.task is not set");
  ExpectUsageError(Parse({"run", "--run", "--task", "push"}), "--run needs a value");
  ExpectUsageError(Parse({"run", "--run", "a/b", "--task", "push"}), "run name \"a/b\"");
  ExpectUsageError(ParseRun({"surplus"}), "unexpected argument \"surplus\"");
  ExpectUsageError(ParseRun({"status"}), "unexpected argument \"status\"");
  ExpectUsageError(ParseRun({"--seed"}), "--seed");
  ExpectUsageError(ParseRun({"--seed", "1", "--seed", "2"}), "--seed");
  ExpectUsageError(ParseRun({"--new-total"}), "--new-total is for --resume only");
  ExpectUsageError(Parse({"inspect"}), "name the CHECKPOINT");
}

TEST_F(OptionsTest, NumbersNeverWrapAround) {
  ExpectUsageError(ParseRun({"--seed", "-1"}), "--seed: seed is \"-1\": must be an integer from 0");
  ExpectUsageError(ParseRun({"--steps", "-5"}), "--steps: total_steps is \"-5\"");
  ExpectUsageError(ParseRun({"--domain", "-1"}), "--domain: runtime.domain is \"-1\"");
  ExpectUsageError(ParseRun({"--domain", "4294967296"}), "runtime.domain");
  ExpectUsageError(ParseRun({"--heads", "-3"}), "--heads: policy.heads is -3");
  ExpectUsageError(ParseRun({"--heads", "501"}), "--heads: policy.heads is 501: must be at most");
  ExpectUsageError(ParseRun({"--heads", "3x"}), "--heads: policy.heads is \"3x\"");
  ExpectUsageError(ParseRun({"--set", "ppo.learning_rate=nan"}), "ppo.learning_rate is nan");
  ExpectUsageError(ParseRun({"--set", "policy.initial_log_std=inf"}), "initial_log_std is inf");
}

TEST_F(OptionsTest, HelpNamesEveryOptionWithItsDefaultAndExitsZero) {
  const auto parsed = Parse({"run", "--help"});
  ASSERT_TRUE(std::holds_alternative<int>(parsed));
  EXPECT_EQ(std::get<int>(parsed), 0);
  for (const std::string text : {"--run",
                                 "--runs-dir",
                                 "--resume",
                                 "--new-total",
                                 "--progress",
                                 "--log-level",
                                 "--log-format",
                                 "--task",
                                 "--method",
                                 "--heads",
                                 "--steps",
                                 "[default: 3000000]",
                                 "--seed",
                                 "--horizon",
                                 "--placements",
                                 "--goal",
                                 "--domain",
                                 "--transport",
                                 "--network",
                                 "[default: loopback]",
                                 "--threads",
                                 "--checkpoint-every",
                                 "--metrics",
                                 "[default: off]",
                                 "--config",
                                 "--set",
                                 "`metronome-actor environment`"}) {
    EXPECT_NE(out_.find(text), std::string::npos) << text;
  }
}

TEST_F(OptionsTest, AnExistingRunNeedsResume) {
  MakeRun(Run({}).config);
  ExpectUsageError(ParseRun({}), "--resume goes on with it");
}

TEST_F(OptionsTest, ResumingTakesTheRunsOwnConfiguration) {
  MakeRun(Run({"--heads", "3", "--set", "policy.hidden=16,16", "--domain", "5"}).config);
  const auto parsed =
      Parse({"run", "--run", "demo", "--runs-dir", runs_, "--resume", "--transport", "shm"});
  ASSERT_TRUE(std::holds_alternative<LearnerCommand>(parsed)) << err_;
  const auto options = std::get<RunOptions>(std::get<LearnerCommand>(parsed));
  EXPECT_TRUE(options.resume);
  EXPECT_EQ(options.config.environment().task(), "push");
  EXPECT_EQ(options.config.policy().heads(), 3);
  EXPECT_EQ(options.config.policy().hidden_size(), 2);
  EXPECT_EQ(options.config.runtime().domain(), 5u);
  EXPECT_EQ(options.config.runtime().transport(), "shm");
  EXPECT_TRUE(Run({"--resume", "--heads", "3"}).resume) << "what agrees may be said again";
  SetTask("push-v3");
  EXPECT_TRUE(Run({"--resume"}).resume) << "another spelling is the same task";
}

TEST_F(OptionsTest, ResumingWithAnotherConfigurationIsRefusedByName) {
  MakeRun(Run({}).config);
  ExpectUsageError(ParseRun({"--resume", "--heads", "5"}),
                   "policy.heads: the run has 10, asked for 5");
  ExpectUsageError(ParseRun({"--resume", "--steps", "4000000"}), "--new-total allows it");
  EXPECT_EQ(Run({"--resume", "--steps", "4000000", "--new-total"}).config.total_steps(), 4000000u);
  SetTask("assembly");
  ExpectUsageError(ParseRun({"--resume"}),
                   "environment.task: the run has push, asked for assembly");
}

TEST_F(OptionsTest, ResumingARunThatIsNotThereNamesTheFile) {
  ExpectUsageError(ParseRun({"--resume"}), "no run to resume: there is no " + runs_);
}

/// A run of three heads whose checkpoint of version 12 is whole, and one to begin others with.
class CheckpointOptionsTest : public OptionsTest {
 protected:
  CheckpointOptionsTest() {
    config_ = Run({"--heads", "3", "--set", "policy.hidden=2", "--steps", "4000"}).config;
    MakeRun(config_);
    Save(config_);
  }

  void Save(const RunConfig& config) {
    checkpoint::Checkpoint checkpoint;
    checkpoint.config = config;
    checkpoint.state.version = 12;
    const policy::NetworkShape shape = policy::ShapeOf(config);
    PolicySnapshot& policy = checkpoint.state.policy;
    policy.parameters.assign(policy::ActorLayout(shape).size, 0.25F);
    policy.observation_mean.assign(39, 0.0F);
    policy.observation_inv_std.assign(39, 1.0F);
    checkpoint.state.algorithm = {"ppo", 1, ""};
    checkpoint::CheckpointStore(Folder() + "/checkpoints", 5).Save(checkpoint);
  }

  [[nodiscard]] std::string Folder() const { return runs_ + "/demo"; }
  [[nodiscard]] std::string File() const { return Folder() + "/checkpoints/000012.ckpt"; }

  void WriteConfig(const std::string& text) const {
    std::ofstream(record::ConfigPathOf(Folder()), std::ios::trunc | std::ios::binary) << text;
  }

  RunOptions Resume() {
    const auto parsed = Parse({"run", "--run", "demo", "--runs-dir", runs_, "--resume"});
    if (std::holds_alternative<int>(parsed)) {
      ADD_FAILURE() << err_;
      return {};
    }
    return std::get<RunOptions>(std::get<LearnerCommand>(parsed));
  }

  /// Of a new run of three heads that begins with the checkpoint.
  std::variant<int, LearnerCommand> ParseFrom(std::vector<std::string> more) {
    more.insert(more.begin(), {"run", "--run", "new", "--runs-dir", runs_, "--task", "assembly",
                               "--set", "policy.hidden=2", "--from", File()});
    return Parse(more);
  }

  RunConfig config_;
};

TEST_F(CheckpointOptionsTest, AConfigurationThatIsLostOrTornIsTheCheckpoints) {
  const std::string whole = config::PrintConfig(config_);
  EXPECT_TRUE(Resume().warnings.empty());
  for (std::size_t size = 0; size < whole.size(); size += 7) {
    WriteConfig(whole.substr(0, size));
    const RunOptions options = Resume();
    EXPECT_EQ(config::PrintConfig(options.config), whole) << size;
    ASSERT_EQ(options.warnings.size(), 1U);
    EXPECT_NE(options.warnings[0].find("is not whole: it is made anew from " + Folder()),
              std::string::npos);
  }
  WriteConfig(std::string(whole.size(), '\0'));
  EXPECT_EQ(Resume().config.total_steps(), 4000U);
  fs::remove(record::ConfigPathOf(Folder()));
  EXPECT_EQ(config::PrintConfig(Resume().config), whole);
}

TEST_F(CheckpointOptionsTest, AConfigurationThatIsLostBesideDamagedCheckpointsIsRefused) {
  WriteConfig("");
  std::ofstream(File(), std::ios::trunc) << "no checkpoint";
  ExpectUsageError(ParseRun({"--resume"}), "is not whole, and no checkpoint in");
  fs::remove(File());
  fs::remove(Folder() + "/checkpoints/latest");
  ExpectUsageError(ParseRun({"--resume"}),
                   "is not whole, and the run has no checkpoint: begin anew");
  fs::remove(record::ConfigPathOf(Folder()));
  ExpectUsageError(ParseRun({"--resume"}), "is missing, and the run has no checkpoint: begin anew");
}

TEST_F(CheckpointOptionsTest, AWholeConfigurationThatCannotBeReadIsNamedWithTheWayOut) {
  WriteConfig("polisy { heads: 3 }\n" + config::PrintConfig(config_));
  ExpectUsageError(ParseRun({"--resume"}), "config.textproto:1:1: unknown setting");
  EXPECT_NE(err_.find("without the file, --resume takes"), std::string::npos) << err_;
}

TEST_F(CheckpointOptionsTest, ANewRunMayBeginWithTheWeightsOfAnother) {
  const auto parsed = ParseFrom({"--heads", "3", "--horizon", "50", "--goal", "hidden"});
  ASSERT_TRUE(std::holds_alternative<LearnerCommand>(parsed)) << err_;
  const auto options = std::get<RunOptions>(std::get<LearnerCommand>(parsed));
  EXPECT_EQ(options.config.policy().initial_weights(), File());
  const auto differences =
      run::DifferencesFrom(run::LoadInitialWeights(options.config, test::Describe), options.config);
  const std::string text = ::testing::PrintToString(differences.intended);
  for (const std::string line :
       {"environment.task: trained with push, this run has assembly",
        "environment.horizon: trained with 500, this run has 50",
        "environment.goal_visible: trained with true, this run has false", "engine: "}) {
    EXPECT_NE(text.find(line), std::string::npos) << text;
  }
  EXPECT_EQ(differences.intended.size(), 4U) << text;
  EXPECT_TRUE(differences.doubtful.empty());
}

TEST_F(CheckpointOptionsTest, AnotherMeaningOfTheHeadsIsDoubtful) {
  RunConfig config = config_;
  config.mutable_policy()->set_initial_weights(File());
  config.mutable_policy()->set_schedule(SCHEDULE_INTERLEAVED);
  const auto differences =
      run::DifferencesFrom(run::LoadInitialWeights(config, test::Describe), config);
  EXPECT_EQ(differences.doubtful,
            (std::vector<std::string>{"policy.schedule: trained with blocks, this run has "
                                      "interleaved"}));
}

TEST_F(CheckpointOptionsTest, WeightsOfAnotherNetworkAreRefusedByName) {
  ExpectUsageError(ParseFrom({"--heads", "4"}), "its policy.heads is 3, this run's is 4");
  ExpectUsageError(ParseFrom({"--method", "ppo"}),
                   "its policy.method is multihead, this run's is single");
  ExpectUsageError(ParseFrom({"--heads", "3", "--set", "policy.hidden=2,2"}),
                   "its policy.hidden is 2, this run's is 2,2");
  ExpectUsageError(ParseFrom({"--heads", "3", "--set", "policy.critic_heads=shared"}),
                   "its policy.critic_heads is separate, this run's is shared");
  EXPECT_FALSE(fs::exists(runs_ + "/new"));
}

TEST_F(CheckpointOptionsTest, WeightsThatCannotBeReadAreNamed) {
  ExpectUsageError(Parse({"run", "--run", "new", "--runs-dir", runs_, "--task", "push", "--from",
                          "/no/such.ckpt"}),
                   "--from: cannot read checkpoint /no/such.ckpt");
  std::ofstream(File(), std::ios::trunc) << "no checkpoint";
  ExpectUsageError(ParseFrom({"--heads", "3"}), "000012.ckpt: not a Metronome checkpoint");
}

TEST_F(CheckpointOptionsTest, TheSameCommandGoesOnAndOtherWeightsAreRefused) {
  RunConfig config = config_;
  config.mutable_policy()->set_initial_weights("/gone/since.ckpt");
  MakeRun(config);
  EXPECT_TRUE(Run({"--resume", "--from", "/gone/../gone/since.ckpt"}).resume);
  ExpectUsageError(ParseRun({"--resume", "--from", "/other.ckpt"}),
                   "policy.initial_weights: the run has /gone/since.ckpt, asked for /other.ckpt");
  MakeRun(config_);
  ExpectUsageError(ParseRun({"--resume", "--from", "/other.ckpt"}),
                   "policy.initial_weights: the run has none, asked for /other.ckpt");
}

TEST_F(OptionsTest, InspectTakesAFileAndAStyle) {
  const auto parsed = Parse({"inspect", "a.ckpt", "--json"});
  ASSERT_TRUE(std::holds_alternative<LearnerCommand>(parsed)) << err_;
  const auto options = std::get<InspectOptions>(std::get<LearnerCommand>(parsed));
  EXPECT_EQ(options.checkpoint, "a.ckpt");
  EXPECT_TRUE(options.json);
}

TEST_F(OptionsTest, ConfigPrintsWhatRunWouldUse) {
  const auto parsed = Parse({"config", "--task", "push", "--set", "ppo.clip=0.1"});
  ASSERT_TRUE(std::holds_alternative<LearnerCommand>(parsed)) << err_;
  const auto options = std::get<PrintConfigOptions>(std::get<LearnerCommand>(parsed));
  EXPECT_EQ(options.config.ppo().clip(), 0.1);
}

checkpoint::Checkpoint TwoHeads() {
  checkpoint::Checkpoint checkpoint;
  test::SetTask(checkpoint.config, "push");
  config::SetField(checkpoint.config, "policy.hidden", "2");
  config::SetField(checkpoint.config, "policy.heads", "2");
  checkpoint.config = config::Resolve(checkpoint.config);
  const policy::NetworkShape shape = policy::ShapeOf(checkpoint.config);
  checkpoint.state.policy.parameters.assign(policy::ActorLayout(shape).size, 0.25F);
  checkpoint.state.weights = {policy::ParameterCount(shape), "00ff"};
  checkpoint.state.algorithm = {"ppo", 1, "opaque"};
  // Head 0 keeps log-std 0, head 1 gets ln 2: means of exp are 1 and 2.
  const std::size_t log_std = policy::ActorLayout(shape).log_std;
  for (std::size_t i = 0; i < 8; ++i) {
    checkpoint.state.policy.parameters[log_std + i] = i < 4 ? 0.0F : std::log(2.0F);
  }
  checkpoint.state.version = 12;
  checkpoint.state.steps = 96000;
  checkpoint.engine = "mujoco-2.2.2";
  checkpoint.isa = "avx2";
  return checkpoint;
}

TEST(InspectTest, JsonHasTheStableKeys) {
  const checkpoint::Checkpoint checkpoint = TwoHeads();
  std::ostringstream out;
  record::PrintCheckpointJson(checkpoint, out);
  const auto json = nlohmann::json::parse(out.str());
  EXPECT_EQ(json.at("version"), 12);
  EXPECT_EQ(json.at("steps"), 96000);
  EXPECT_EQ(json.at("weights_sha256"), "00ff");
  EXPECT_EQ(json.at("algorithm"), "ppo");
  EXPECT_EQ(json.at("algorithm_format"), 1);
  EXPECT_EQ(json.at("task"), "push");
  EXPECT_EQ(json.at("method"), "multihead");
  EXPECT_EQ(json.at("heads"), 2);
  EXPECT_EQ(json.at("schedule"), "blocks");
  EXPECT_EQ(json.at("critic_heads"), "separate");
  // 39 inputs, 2 units: 80 below the heads, 82 where the time is an input; a head of 4 has 12 and 4
  // log-stds, of the critic 3.
  EXPECT_EQ(json.at("actor_parameters"), 80 + 2 * (12 + 4));
  EXPECT_EQ(json.at("critic_parameters"), 82 + 2 * 3);
  EXPECT_EQ(json.at("parameters"), 80 + 2 * (12 + 4) + 82 + 2 * 3);
  EXPECT_EQ(json.at("engine"), "mujoco-2.2.2");
  EXPECT_EQ(json.at("isa"), "avx2");
  EXPECT_NEAR(json.at("head_std").at(0), 1, 1e-6);
  EXPECT_NEAR(json.at("head_std").at(1), 2, 1e-6);
  EXPECT_EQ(out.str().find('\n'), out.str().size() - 1) << "more than one line";
}

TEST(InspectTest, ASharedCriticHasTheParametersOfOneHead) {
  checkpoint::Checkpoint checkpoint = TwoHeads();
  config::SetField(checkpoint.config, "policy.critic_heads", "shared");
  checkpoint.state.weights.count = policy::ParameterCount(policy::ShapeOf(checkpoint.config));
  std::ostringstream out;
  record::PrintCheckpointJson(checkpoint, out);
  const auto json = nlohmann::json::parse(out.str());
  EXPECT_EQ(json.at("critic_heads"), "shared");
  EXPECT_EQ(json.at("critic_parameters"), 82 + 3);
  EXPECT_EQ(json.at("parameters"), 80 + 2 * (12 + 4) + 82 + 3);
  EXPECT_EQ(json.at("head_std").size(), 2U);
}

TEST(InspectTest, TextNamesTheSame) {
  std::ostringstream out;
  record::PrintCheckpoint(TwoHeads(), out);
  EXPECT_NE(out.str().find("version           12\n"), std::string::npos) << out.str();
  EXPECT_NE(out.str().find("task              push\n"), std::string::npos);
  EXPECT_NE(out.str().find("critic_parameters 88\n"), std::string::npos);
  EXPECT_EQ(out.str().find("initial_weights"), std::string::npos);
}

TEST(InspectTest, WeightsThatARunBeganWithAreNamedWhateverTheirPathIs) {
  checkpoint::Checkpoint checkpoint = TwoHeads();
  checkpoint.config.mutable_policy()->set_initial_weights("/runs/\xff.ckpt");
  checkpoint.initial_weights_sha256 = "00ff";
  std::ostringstream json, text;
  record::PrintCheckpointJson(checkpoint, json);
  EXPECT_EQ(nlohmann::json::parse(json.str()).at("initial_weights_sha256"), "00ff");
  record::PrintCheckpoint(checkpoint, text);
  EXPECT_NE(text.str().find("\ninitial_weights_sha256 00ff\n"), std::string::npos) << text.str();
}

TEST_F(OptionsTest, StatusShowsARunOfAnyName) {
  for (const std::string name : {"demo", "run", "config", "status"}) {
    const auto parsed = Parse({"status", name});
    ASSERT_TRUE(std::holds_alternative<LearnerCommand>(parsed)) << err_;
    EXPECT_EQ(std::get<StatusOptions>(std::get<LearnerCommand>(parsed)).run, name);
  }
  const auto parsed = Parse({"status", "--run", "demo"});
  ASSERT_TRUE(std::holds_alternative<LearnerCommand>(parsed)) << err_;
  EXPECT_EQ(std::get<StatusOptions>(std::get<LearnerCommand>(parsed)).run, "demo");
  ExpectUsageError(Parse({"status"}), "name the run to show: metronome-learner status NAME");
  ExpectUsageError(Parse({"status", "demo", "--domain", "233"}), "from 0 to 232");
  ExpectUsageError(Parse({"status", "demo", "--wait", "nan"}), "from 0 to 86400");
}

}  // namespace
}  // namespace metronome::learner
