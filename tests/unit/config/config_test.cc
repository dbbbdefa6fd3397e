#include "common/config/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "common/text/listen_address.h"
#include "tests/unit/support/environments.h"

namespace metronome::config {
namespace {

/// The message of a ConfigError; fails the test if there is none.
std::string ErrorOf(const std::function<void()>& act) {
  try {
    act();
  } catch (const ConfigError& error) {
    return error.what();
  }
  ADD_FAILURE() << "no ConfigError";
  return "";
}

std::string ParseErrorOf(const std::string& text) {
  return ErrorOf([&] { ParseConfigText(text, "run.cfg"); });
}

RunConfig Push() {
  RunConfig config;
  test::SetTask(config, "push");
  return config;
}

/// Complaint about push's defaults with one setting changed.
std::string ComplaintOf(const std::string& path, const std::string& value) {
  RunConfig config = Push();
  SetField(config, path, value);
  return ErrorOf([&] { Validate(Resolve(config)); });
}

void ExpectAccepted(const std::string& path, const std::string& value) {
  RunConfig config = Push();
  SetField(config, path, value);
  EXPECT_NO_THROW(Validate(Resolve(config))) << path << "=" << value;
}

TEST(CompleteSpecTest, EveryNameLeadsToTheShortOneAndASpecificationIsAskedForOnce) {
  RunConfig config;
  int asked = 0;
  const SpecSource source = [&asked](const std::string& name) {
    ++asked;
    return test::Describe(name);
  };
  CompleteSpec(config, source);
  EXPECT_EQ(asked, 0) << "there is nothing to ask for";
  for (const std::string name : {"push-v3", "push", "metaworld/push"}) {
    config.mutable_environment()->set_task(name);
    CompleteSpec(config, source);
    EXPECT_EQ(config.environment().task(), "push");
    EXPECT_EQ(config.environment().spec().name(), "metaworld/push");
    EXPECT_EQ(asked, 1);
  }
  config.mutable_environment()->set_task("assembly");
  CompleteSpec(config, source);
  EXPECT_EQ(config.environment().spec().name(), "metaworld/assembly") << "another environment";
}

TEST(CompleteSpecTest, AnUnknownNameIsAComplaintAndOtherErrorsPass) {
  RunConfig config;
  config.mutable_environment()->set_task("pussh");
  EXPECT_EQ(
      ErrorOf([&] { CompleteSpec(config, test::Describe); }),
      "environment.task is an unknown environment \"pussh\"; Known: assembly, box-close, push");
  EXPECT_EQ(ErrorOf([&] {
              CompleteSpec(config, [](const std::string&) -> EnvironmentSpec {
                throw ConfigError("no program");
              });
            }),
            "no program");
}

TEST(CompleteSpecTest, WhatIsDescribedIsTheHorizonsDefaultAndBound) {
  RunConfig config = Push();
  config.mutable_environment()->mutable_spec()->set_max_steps(60);
  EXPECT_EQ(Resolve(config).environment().horizon(), 60);
  config.mutable_environment()->set_horizon(61);
  EXPECT_EQ(
      ErrorOf([&] { Validate(Resolve(config)); }),
      "environment.horizon is 61: must be from 1 to 60, the longest episode of metaworld/push");
  config.mutable_environment()->clear_spec();
  EXPECT_EQ(ErrorOf([&] { Validate(Resolve(config)); }),
            "environment.spec is not that of push: nothing says how large its observations are");
}

TEST(ResolveTest, FillsEveryField) {
  const RunConfig config = Resolve(Push());
  const std::set<std::string> of_several = {"environment.spec.tasks",
                                            "environment.spec.has_benchmark"};
  VisitFields(config, [&](const std::string& path, const auto& owner, const auto& field) {
    if (of_several.contains(path)) return;
    if (field.is_repeated())
      EXPECT_GT(owner.GetReflection()->FieldSize(owner, &field), 0) << path;
    else
      EXPECT_TRUE(owner.GetReflection()->HasField(owner, &field)) << path;
  });
  EXPECT_EQ(config.policy().heads(), 10);
  EXPECT_EQ(config.policy().hidden(0), 128);
  EXPECT_EQ(config.policy().hidden(1), 128);
  EXPECT_EQ(config.ppo().minibatch(), 2000);
  EXPECT_EQ(config.total_steps(), 3000000u);
  EXPECT_NO_THROW(Validate(config));
}

TEST(ResolveTest, DerivedDefaultsFollowWhatElseIsSet) {
  RunConfig config = Push();
  config.mutable_policy()->set_method(SINGLE_TIME);
  config.mutable_environment()->set_horizon(20);
  config = Resolve(config);
  EXPECT_EQ(config.policy().heads(), 1);
  EXPECT_EQ(config.ppo().minibatch(), 640);
}

TEST(ResolveTest, KeepsWhatIsSetAndIsIdempotent) {
  RunConfig config = Push();
  SetField(config, "policy.hidden", "64,32,16");
  SetField(config, "policy.heads", "3");
  SetField(config, "ppo.entropy_coefficient_final", "0.25");
  const RunConfig once = Resolve(config);
  EXPECT_EQ(FieldText(once.policy(), *PolicyConfig::descriptor()->FindFieldByName("hidden")),
            "64,32,16");
  EXPECT_EQ(once.policy().heads(), 3);
  EXPECT_EQ(once.ppo().entropy_coefficient_final(), 0.25);
  EXPECT_EQ(PrintConfig(Resolve(once)), PrintConfig(once));
}

TEST(PrintConfigTest, PrintoutReadsBackBitForBit) {
  RunConfig config = Push();
  SetField(config, "ppo.learning_rate", "0.00030000000000000003");
  SetField(config, "seed", "18446744073709551615");
  SetField(config, "policy.schedule", "shuffled");
  SetField(config, "policy.critic_heads", "shared");
  config = Resolve(config);
  const RunConfig back = ParseConfigText(PrintConfig(config), "printout").config;
  EXPECT_EQ(back.SerializeAsString(), config.SerializeAsString());
}

TEST(ParseConfigTest, ErrorsNameFileLineAndColumn) {
  EXPECT_EQ(ParseErrorOf("seed: 1\nppo {\n  learning_rte: 1\n}\n").substr(0, 75),
            "run.cfg:3:3: unknown setting of ppo \"learning_rte\"; did you mean \"learning_");
  EXPECT_EQ(
      ParseErrorOf("sed: 1"),
      "run.cfg:1:1: unknown setting \"sed\"; did you mean \"seed\"? Known: environment, policy, "
      "ppo, sac, custom, collection, runtime, seed, total_steps");
  EXPECT_EQ(ParseErrorOf("ppo { success_reward: 25 }"),
            "run.cfg:1:7: ppo.success_reward is environment.success_reward now, with "
            "environment.reward=success");
  EXPECT_EQ(ParseErrorOf("policy { method: MULTIHED }"),
            "run.cfg:1:18: unknown value of policy.method \"MULTIHED\"; did you mean "
            "\"MULTIHEAD\"? Known: MULTIHEAD, SINGLE, SINGLE_TIME, PPO, PPO_TIME");
  EXPECT_EQ(ParseErrorOf("# note\n\tseed: x").substr(0, 13), "run.cfg:2:8: ");
  EXPECT_EQ(ParseErrorOf("ppo {\n\n\n  clip: 0.2\n  clip: 0.1 }").substr(0, 13), "run.cfg:5:3: ");
  EXPECT_EQ(ParseErrorOf("environment {\n  goal_visible: maybe\n}").substr(0, 14),
            "run.cfg:2:17: ");
  EXPECT_EQ(ParseErrorOf("policy {\n  heads: 99999999999\n}").substr(0, 14), "run.cfg:2:10: ");
  EXPECT_EQ(ParseErrorOf("policy {\n  heads: 3\n").substr(0, 13), "run.cfg:3:1: ");
  EXPECT_EQ(ParseErrorOf("seed: -1").substr(0, 13), "run.cfg:1:7: ");
}

TEST(ParseConfigTest, AWordIsJudgedByItsPlaceInTheFile) {
  const std::string unknown =
      "unknown setting of runtime \"transprt\"; did you mean \"transport\"?";
  for (const std::string before :
       {"runtime { network: 'a' \"b\" ", "policy < hidden: [8, 8]; heads: -1, > runtime: { ",
        "policy { method: PPO } ppo { clip: .1f kl_stop: 1 } runtime { ",
        "environment { goal_visible: t placements: 2 }  # { sed: 1\nruntime { "}) {
    EXPECT_NE(ParseErrorOf(before + "transprt: 'tcp' }").find(": " + unknown), std::string::npos)
        << before;
  }
  EXPECT_EQ(
      ParseErrorOf("environment {\n  goal_visible: maybe\n}"),
      "run.cfg:2:17: unknown value of environment.goal_visible \"maybe\". Known: true, false, "
      "True, False, t, f");
  EXPECT_EQ(ParseErrorOf("ppo { clip: 0.2 }\nppo { clip: 0.1 }"), "run.cfg:2:1: ppo is set twice");
  EXPECT_EQ(ParseErrorOf("ppo { clip: 0.2\n  clip: 0.1 }"), "run.cfg:2:3: ppo.clip is set twice");
}

TEST(ParseConfigTest, TheFirstErrorIsTold) {
  EXPECT_EQ(ParseErrorOf("seed = 1\nsed: 2").substr(0, 13), "run.cfg:1:6: ");
  EXPECT_EQ(ParseErrorOf("seed: one\nsed: 2").substr(0, 13), "run.cfg:1:7: ");
  EXPECT_EQ(ParseErrorOf("ppo {\n  clip: 'x'\n}\nsed: 2").substr(0, 13), "run.cfg:2:9: ");
  EXPECT_EQ(ParseErrorOf("sed: 2\nseed: one").substr(0, 13), "run.cfg:1:1: ");
}

TEST(ParseConfigTest, AFileOfAnEditorOfWindowsIsRead) {
  const std::string text = "\xef\xbb\xbf# notes\r\nseed: 3\r\nppo {\r\n  clip: 0.1\r\n}\r\n";
  const ParsedConfig parsed = ParseConfigText(text, "run.cfg");
  EXPECT_EQ(parsed.config.seed(), 3U);
  EXPECT_EQ(parsed.origins.at("ppo.clip"), "run.cfg:4:3");
  EXPECT_EQ(ParseErrorOf("\xef\xbb\xbfseed: -1").substr(0, 13), "run.cfg:1:7: ");
}

// Configurations, files and scripts from when PPO was the only algorithm.
TEST(MethodTest, TheOldNamesGoOnToMeanTheSame) {
  const auto of_file = [](const std::string& method) {
    RunConfig config = Push();
    Overlay(config, ParseConfigText("policy { method: " + method + " }", "run.cfg").config);
    return Resolve(config);
  };
  EXPECT_EQ(of_file("PPO").policy().method(), SINGLE);
  EXPECT_EQ(of_file("PPO_TIME").policy().method(), SINGLE_TIME);
  EXPECT_TRUE(CompareForResume(of_file("PPO"), of_file("SINGLE"), false).empty());
  EXPECT_EQ(PrintConfig(of_file("PPO_TIME")), PrintConfig(of_file("SINGLE_TIME")));
  for (const auto& [old_name, name] :
       {std::pair{"ppo", "single"}, std::pair{"ppo-time", "single-time"},
        std::pair{"PPO", "SINGLE"}}) {
    RunConfig by_old = Push(), by_name = Push();
    SetField(by_old, "policy.method", old_name);
    SetField(by_name, "policy.method", name);
    EXPECT_EQ(by_old.SerializeAsString(), by_name.SerializeAsString()) << name;
  }
}

TEST(AlgorithmTest, IsPpoWhereNothingIsSaidAndItsSettingsAreAsEver) {
  const RunConfig config = Resolve(Push());
  EXPECT_EQ(AlgorithmName(config), "ppo");
  EXPECT_TRUE(config.has_ppo());
  // Field 3 of the whole, as before there was a choice: ppo { clip: 0.5 }.
  RunConfig old;
  ASSERT_TRUE(old.ParseFromString(std::string("\x1a\x09\x31\0\0\0\0\0\0\xe0\x3f", 11)));
  EXPECT_EQ(old.ppo().clip(), 0.5);
}

TEST(AlgorithmTest, AnotherOneIsNamedWithSettingsThatOnlyItReads) {
  RunConfig config = Push();
  SetField(config, "custom.name", "other");
  EXPECT_EQ(ErrorOf([&] { SetField(config, "ppo.clip", "0.1"); }),
            "ppo.clip: custom is set already, and the algorithm is one alone");
  SetField(config, "custom.settings", "population: 5");
  config = Resolve(config);
  EXPECT_FALSE(config.has_ppo());
  EXPECT_EQ(AlgorithmName(config), "other");
  EXPECT_NO_THROW(Validate(config));
  const std::string printed = PrintConfig(config);
  EXPECT_NE(printed.find("custom {\n  name: \"other\"\n  settings: \"population: 5\"\n}"),
            std::string::npos)
      << printed;
  EXPECT_EQ(ParseConfigText(printed, "x").config.SerializeAsString(), config.SerializeAsString());
  RunConfig changed = config;
  SetField(changed, "custom.settings", "population: 6");
  EXPECT_EQ(CompareForResume(config, changed, false).at(0),
            "custom.settings: the run has population: 5, asked for population: 6");
  EXPECT_EQ(CompareForResume(config, Resolve(Push()), false),
            std::vector<std::string>{"the algorithm: the run has other, asked for ppo"});
  SetField(config, "custom.name", "");
  EXPECT_EQ(ErrorOf([&] { Validate(config); }),
            "custom.name is not set: name an algorithm that the learner knows");
}

TEST(ParseConfigTest, AnotherEncodingIsNamed) {
  for (const std::string& text : {std::string("\xff\xfes\0", 4), std::string("\xfe\xff\0s", 4)}) {
    EXPECT_NE(ParseErrorOf(text).find("saved as UTF-16: save it as UTF-8"), std::string::npos);
  }
}

TEST(ParseConfigTest, EmptyTextIsAnEmptyConfiguration) {
  EXPECT_EQ(ParseConfigText("", "run.cfg").config.SerializeAsString(), "");
  EXPECT_EQ(ParseConfigText("# only a comment\n", "run.cfg").config.SerializeAsString(), "");
}

TEST(ParseConfigTest, UnreadableFilesAreNamed) {
  EXPECT_EQ(ErrorOf([] { ParseConfigFile("no/such/file"); }),
            "cannot read configuration file no/such/file: No such file or directory");
  EXPECT_NE(ErrorOf([] { ParseConfigFile("."); }).find("cannot read configuration file ."),
            std::string::npos);
}

TEST(ParseConfigTest, ThePresetsAreValid) {
  int presets = 0;
  for (const auto& entry : std::filesystem::directory_iterator(METRONOME_SOURCE_DIR "/deploy")) {
    if (entry.path().extension() != ".textproto") continue;
    ++presets;
    RunConfig config = Push();
    Overlay(config, ParseConfigFile(entry.path().string()).config);
    EXPECT_NO_THROW(Validate(Resolve(config))) << entry.path();
  }
  EXPECT_GT(presets, 0);
}

TEST(SetFieldTest, SetsEveryTypeFromText) {
  RunConfig config;
  SetField(config, "policy.method", "ppo-time");
  SetField(config, "environment.placements", "mt1");
  SetField(config, "environment.goal_visible", "false");
  SetField(config, "policy.schedule", "interleaved");
  SetField(config, "policy.critic_heads", "shared");
  SetField(config, "ppo.learning_rate", "3e-4");
  SetField(config, "policy.hidden", "64,64");
  SetField(config, "policy.hidden", "32");
  SetField(config, "runtime.domain", "7");
  SetField(config, "runtime.network", "10.0.0.1,10.0.0.2");
  EXPECT_EQ(config.policy().method(), SINGLE_TIME);
  EXPECT_EQ(config.environment().placements(), PLACEMENTS_MT1);
  EXPECT_FALSE(config.environment().goal_visible());
  EXPECT_EQ(config.policy().schedule(), SCHEDULE_INTERLEAVED);
  EXPECT_EQ(config.policy().critic_heads(), CRITIC_HEADS_SHARED);
  EXPECT_EQ(config.ppo().learning_rate(), 3e-4);
  ASSERT_EQ(config.policy().hidden_size(), 1);
  EXPECT_EQ(config.policy().hidden(0), 32);
  EXPECT_EQ(config.runtime().domain(), 7u);
  EXPECT_EQ(config.runtime().network(), "10.0.0.1,10.0.0.2");
  SetField(config, "policy.method", "MULTIHEAD");
  EXPECT_EQ(config.policy().method(), MULTIHEAD);
  SetField(config, "policy.critic_heads", "CRITIC_HEADS_SEPARATE");
  EXPECT_EQ(config.policy().critic_heads(), CRITIC_HEADS_SEPARATE);
}

TEST(SetFieldTest, UnknownPathsGetTheNearMissAndThatGroupsList) {
  RunConfig config;
  EXPECT_EQ(ErrorOf([&] { SetField(config, "ppoo.clip", "1"); }),
            "unknown setting \"ppoo\"; did you mean \"ppo\"? Known: environment, policy, ppo, sac, "
            "custom, "
            "collection, runtime, seed, total_steps");
  EXPECT_EQ(ErrorOf([&] { SetField(config, "collection.overlp", "1"); }),
            "unknown setting of collection \"overlp\"; did you mean \"overlap\"? Known: "
            "episodes_per_update, overlap, check_share, check_tolerance");
  EXPECT_EQ(ErrorOf([&] { SetField(config, "collection", "1"); }),
            "collection is a group of settings: name one of collection.episodes_per_update, "
            "collection.overlap, collection.check_share, collection.check_tolerance");
  EXPECT_EQ(ErrorOf([&] { SetField(config, "seed.x", "1"); }),
            "seed.x: seed is one setting, nothing lies in it");
  EXPECT_THROW(SetField(config, "", "1"), ConfigError);
  EXPECT_THROW(SetField(config, "ppo.", "1"), ConfigError);
}

TEST(SetFieldTest, TextOfAnotherTypeIsRefusedByName) {
  RunConfig config;
  EXPECT_EQ(ErrorOf([&] { SetField(config, "seed", "-1"); }),
            "seed is \"-1\": must be an integer from 0 to 18446744073709551615");
  EXPECT_EQ(ErrorOf([&] { SetField(config, "policy.heads", "2.5"); }),
            "policy.heads is \"2.5\": must be an integer from -2147483648 to 2147483647");
  EXPECT_EQ(ErrorOf([&] { SetField(config, "ppo.clip", "0.2x"); }),
            "ppo.clip is \"0.2x\": must be a number");
  EXPECT_EQ(ErrorOf([&] { SetField(config, "policy.method", "pppo"); }),
            "unknown value of policy.method \"pppo\"; did you mean \"ppo\"? Known: multihead, "
            "single, single-time, ppo, ppo-time");
  EXPECT_EQ(ErrorOf([&] { SetField(config, "policy.schedule", "shufled"); }),
            "unknown value of policy.schedule \"shufled\"; did you mean \"shuffled\"? Known: "
            "blocks, interleaved, shuffled");
  EXPECT_EQ(ErrorOf([&] { SetField(config, "policy.critic_heads", "share"); }),
            "unknown value of policy.critic_heads \"share\"; did you mean \"shared\"? Known: "
            "separate, shared");
  for (const std::string text : {"", "64,", ",64", "64;64"}) {
    EXPECT_THROW(SetField(config, "policy.hidden", text), ConfigError) << text;
  }
  for (const std::string text : {"", "yes", "2"}) {
    EXPECT_THROW(SetField(config, "environment.goal_visible", text), ConfigError) << text;
  }
}

TEST(ValidateTest, DefaultsOfEveryMethodAreAccepted) {
  for (const std::string method : {"multihead", "single", "single-time", "ppo", "ppo-time"}) {
    ExpectAccepted("policy.method", method);
  }
}

TEST(ValidateTest, EachNumberHasItsRange) {
  struct Case {
    std::string path;
    std::vector<std::string> refused, accepted;
  };
  const std::vector<Case> cases = {
      {"total_steps", {"0", "9007199254740992"}, {"1", "9007199254740991"}},
      {"environment.horizon", {"-1", "0", "501", "10001"}, {"10", "500"}},
      {"environment.spec.observation_size", {"-1", "0", "1025"}, {"1", "1024"}},
      {"environment.spec.action_size", {"0", "65"}, {"4"}},
      {"policy.heads", {"-3", "0", "501"}, {"1", "500"}},
      {"policy.hidden", {"0", "64,-1", "4097", "1,1,1,1,1,1,1,1,1"}, {"1", "64,64,64"}},
      {"policy.initial_log_std",
       {"nan", "inf", "-inf", "-20.1", "20.1"},
       {"-20", "-0.5", "1", "20"}},
      {"policy.observation_clip", {"0", "-1", "inf", "1.1e9"}, {"5", "1e9"}},
      {"policy.observation_epsilon", {"0", "9e-17", "1.1", "nan"}, {"1e-16", "1e-8", "1"}},
      {"ppo.learning_rate", {"nan", "inf", "-1e-3", "0"}, {"1e-9", "1e30"}},
      {"ppo.learning_rate_floor", {"-0.1", "1.1", "nan"}, {"0", "1"}},
      {"ppo.adam_epsilon", {"0", "nan"}, {"1e-8"}},
      {"ppo.epochs", {"0", "-1"}, {"1"}},
      {"ppo.minibatch", {"0", "-5", "16001"}, {"1", "16000"}},
      {"ppo.clip", {"0", "-0.2", "nan"}, {"0.1"}},
      {"ppo.value_coefficient", {"-1", "nan"}, {"0"}},
      {"ppo.discount", {"-0.1", "1.01", "nan"}, {"0", "1"}},
      {"ppo.gae_lambda", {"-0.1", "1.01", "nan"}, {"0", "1"}},
      {"ppo.entropy_coefficient", {"-1", "inf"}, {"0"}},
      {"ppo.entropy_coefficient_final", {"-1", "inf"}, {"0"}},
      {"ppo.max_gradient_norm", {"0", "nan"}, {"1"}},
      {"ppo.kl_stop", {"-1", "nan"}, {"0"}},
      {"ppo.min_std", {"-0.1", "10.1", "nan"}, {"0.01", "10"}},
      {"ppo.std_decay", {"-0.1", "1.1", "nan"}, {"0", "1"}},
      {"ppo.reward_scale_decay", {"0", "-0.1", "1.1", "nan"}, {"0.5", "1"}},
      {"ppo.log_std_rate", {"-1", "inf", "nan"}, {"0", "20"}},
      {"ppo.success_weight", {"-1", "nan", "1000001"}, {"0", "0.5", "10"}},
      {"ppo.earlier_batches", {"-1", "101"}, {"1", "100"}},
      {"environment.success_reward", {"-1", "nan", "inf", "1000001"}, {"0", "10"}},
      {"collection.episodes_per_update", {"0", "-16", "10001"}, {"2", "10000"}},
      {"collection.overlap", {"-1", "2"}, {"0", "1"}},
      {"collection.check_share", {"0", "1.5", "nan"}, {"0.01", "1"}},
      {"collection.check_tolerance", {"-1", "inf"}, {"0", "1e-6"}},
      {"runtime.domain", {"233"}, {"0", "232"}},
      {"runtime.learner_threads", {"-1", "1025"}, {"0", "8"}},
      {"runtime.checkpoint_every", {"0", "-1"}, {"100"}},
      {"runtime.checkpoint_keep", {"0", "-1"}, {"1"}},
      {"runtime.milestone_every", {"-1"}, {"0", "25"}},
      {"runtime.audit_share", {"-0.1", "1.1"}, {"0", "0.05", "1"}},
      {"policy.noise_correlation", {"-0.1", "1", "nan"}, {"0", "0.9"}},
  };
  for (const Case& c : cases) {
    for (const auto& value : c.refused) {
      EXPECT_TRUE(ComplaintOf(c.path, value).starts_with(c.path + " ")) << c.path << "=" << value;
    }
    for (const auto& value : c.accepted) ExpectAccepted(c.path, value);
  }
}

TEST(ValidateTest, TheLongestEpisodeHasItsRangeToo) {
  RunConfig config = Push();
  config.mutable_environment()->set_horizon(10);
  for (const int steps : {0, 10001}) {
    config.mutable_environment()->mutable_spec()->set_max_steps(steps);
    EXPECT_EQ(
        ErrorOf([&] { Validate(Resolve(config)); }),
        "environment.spec.max_steps is " + std::to_string(steps) + ": must be from 1 to 10000");
  }
}

TEST(ValidateTest, ComplaintsNameFieldValueAndWhatIsAllowed) {
  EXPECT_EQ(ComplaintOf("policy.heads", "501"),
            "policy.heads is 501: must be at most environment.horizon, 500 (each head needs a "
            "step)");
  EXPECT_EQ(ComplaintOf("policy.heads", "-3"),
            "policy.heads is -3: must be a finite number, at least 1");
  EXPECT_EQ(ComplaintOf("ppo.learning_rate", "nan"),
            "ppo.learning_rate is nan: must be a finite number, above 0");
  EXPECT_EQ(ComplaintOf("total_steps", "0"),
            "total_steps is 0: must be from 1 to 9007199254740991");
  EXPECT_EQ(ComplaintOf("ppo.minibatch", "17000"),
            "ppo.minibatch is 17000: must be at most the steps of an update, 16000 "
            "(episodes_per_update * horizon * (1 + earlier_batches))");
  EXPECT_EQ(ComplaintOf("runtime.transport", "upd"),
            "runtime.transport is an unknown transport \"upd\"; did you mean \"udp\"? Known: udp, "
            "shm, tcp");
  EXPECT_EQ(ComplaintOf("runtime.network", "loopbak"),
            "runtime.network is \"loopbak\"; did you mean \"loopback\"? must be loopback, lan, or "
            "the peers' addresses separated by commas");
  EXPECT_EQ(
      ComplaintOf("runtime.metrics", "9464/tcp"),
      "runtime.metrics is \"9464/tcp\": must be PORT or HOST:PORT, a port from 0 to 65535 and "
      "a numeric IPv4 address");
  EXPECT_EQ(ErrorOf([] { Validate(Resolve(RunConfig())); }),
            "environment.task is not set: choose what `metronome-actor environment` lists");
}

TEST(ValidateTest, AllComplaintsComeAtOnce) {
  RunConfig config = Push();
  SetField(config, "ppo.clip", "0");
  SetField(config, "policy.heads", "0");
  const std::string error = ErrorOf([&] { Validate(Resolve(config)); });
  EXPECT_NE(error.find("ppo.clip is 0"), std::string::npos);
  EXPECT_NE(error.find("policy.heads is 0"), std::string::npos);
}

TEST(ValidateTest, APolicyTooLargeForTheWireIsRefused) {
  EXPECT_EQ(ComplaintOf("policy.hidden", "4096,4096"),
            "policy.hidden and policy.heads make a policy of 17109072 parameters: must be at most "
            "4000000 (what a snapshot holds on the wire)");
}

TEST(ValidateTest, OneHeadMethodsTakeOneHead) {
  RunConfig config = Push();
  SetField(config, "policy.method", "ppo");
  SetField(config, "policy.heads", "2");
  EXPECT_EQ(ErrorOf([&] { Validate(Resolve(config)); }),
            "policy.heads is 2: the method single has exactly 1 (multihead takes more)");
  SetField(config, "policy.heads", "1");
  EXPECT_NO_THROW(Validate(Resolve(config)));
}

TEST(ValidateTest, EveryMethodTakesEveryScheduleAndCritic) {
  for (const std::string method : {"multihead", "single", "single-time", "ppo", "ppo-time"}) {
    for (const std::string& schedule : EnumWords(*Schedule_descriptor())) {
      RunConfig config = Push();
      SetField(config, "policy.method", method);
      SetField(config, "policy.schedule", schedule);
      SetField(config, "policy.critic_heads", "shared");
      EXPECT_NO_THROW(Validate(Resolve(config))) << method << " " << schedule;
    }
  }
}

TEST(ValidateTest, TheOfficialBenchmarksSeedHas32Bits) {
  RunConfig config = Push();
  SetField(config, "seed", "4294967296");
  EXPECT_NO_THROW(Validate(Resolve(config)));
  SetField(config, "environment.placements", "mt1");
  EXPECT_EQ(ErrorOf([&] { Validate(Resolve(config)); }),
            "seed is 4294967296: with official placements it must be from 0 to 4294967295");
}

RunConfig OfTasks(int tasks) {
  RunConfig config = Push();
  for (int i = 0; i < tasks; ++i)
    config.mutable_environment()->mutable_spec()->add_tasks("task" + std::to_string(i));
  return config;
}

TEST(ResolveTest, ABatchOfSeveralTasksHasEquallyManyEpisodesOfEach) {
  for (const auto& [tasks, episodes] : {std::pair(3, 33), {10, 40}, {16, 32}, {50, 50}}) {
    const RunConfig config = Resolve(OfTasks(tasks));
    EXPECT_EQ(config.collection().episodes_per_update(), episodes) << tasks;
    EXPECT_NO_THROW(Validate(config));
  }
  EXPECT_EQ(Resolve(Push()).collection().episodes_per_update(), 32);
}

TEST(ValidateTest, StandardDeviationsFallToALeastOneAboveZero) {
  RunConfig config = Push();
  SetField(config, "ppo.std_decay", "0.7");
  EXPECT_NO_THROW(Validate(Resolve(config)));
  SetField(config, "ppo.min_std", "0");
  EXPECT_EQ(ErrorOf([&] { Validate(Resolve(config)); }),
            "ppo.min_std is 0: must be above 0 for ppo.std_decay, which lowers standard deviations "
            "to it");
}

RunConfig Sac() {
  RunConfig config = Push();
  config.mutable_sac();
  return config;
}

TEST(ResolveTest, SacHasDefaultsOfItsOwnForTheLoop) {
  const RunConfig config = Resolve(Sac());
  EXPECT_EQ(AlgorithmName(config), "sac");
  EXPECT_FALSE(config.has_ppo());
  EXPECT_EQ(config.collection().episodes_per_update(), 4);
  EXPECT_EQ(config.collection().overlap(), 1);
  EXPECT_EQ(config.total_steps(), 2000000U);
  EXPECT_EQ(config.sac().critic_hidden_size(), 2);
  EXPECT_NO_THROW(Validate(config));
  RunConfig set = Sac();
  SetField(set, "collection.overlap", "0");
  SetField(set, "collection.episodes_per_update", "32");
  EXPECT_EQ(Resolve(set).collection().episodes_per_update(), 32);
  EXPECT_EQ(Resolve(set).collection().overlap(), 0);
  SetField(set, "total_steps", "3000000");
  EXPECT_EQ(Resolve(set).total_steps(), 3000000U);
}

TEST(ValidateTest, WhatSacCannotHaveIsNamedWithTheRemedy) {
  const auto complaint = [](const std::string& field, const std::string& value) {
    RunConfig config = Sac();
    SetField(config, field, value);
    return ErrorOf([&] { Validate(Resolve(config)); });
  };
  EXPECT_EQ(complaint("sac.replay_steps", "499"),
            "sac.replay_steps is 499: must be at least 500, a batch and an episode");
  EXPECT_EQ(complaint("sac.replay_ratio", "0.1"),
            "sac.replay_ratio is 0.1: an update's 200 samples make no gradient step of 256 "
            "(sac.batch); raise it, or collection.episodes_per_update");
  EXPECT_EQ(complaint("sac.n_step", "501"),
            "sac.n_step is 501: must be at most environment.horizon, 500");
  EXPECT_NE(complaint("sac.value_limit", "6").find("success alone is worth up to 999.99"),
            std::string::npos);
  RunConfig enough = Sac();
  SetField(enough, "sac.value_limit", "7");
  EXPECT_NO_THROW(Validate(Resolve(enough)));
}

TEST(ResolveTest, HeadsByTaskAreOneEachUnlessByTimeToo) {
  RunConfig config = OfTasks(3);
  SetField(config, "policy.heads_by", "task");
  EXPECT_EQ(Resolve(config).policy().heads(), 1);
  SetField(config, "policy.heads_by", "task-time");
  EXPECT_EQ(Resolve(config).policy().heads(), 10);
}

TEST(ValidateTest, WhatSeveralTasksCannotHaveIsNamedWithTheRemedy) {
  const auto complaint = [](int tasks, const std::string& field, const std::string& value) {
    RunConfig config = OfTasks(tasks);
    SetField(config, field, value);
    return ErrorOf([&] { Validate(Resolve(config)); });
  };
  EXPECT_EQ(
      complaint(3, "collection.episodes_per_update", "16"),
      "collection.episodes_per_update is 16, for push, 3 tasks: must be a multiple, as 18, so "
      "that each has equally many");
  EXPECT_EQ(complaint(3, "environment.placements", "fixed"),
            "environment.placements is fixed, for push, 3 tasks: must be random, mt1");
  EXPECT_EQ(complaint(3, "environment.placements", "benchmark"),
            "environment.placements is benchmark, and push is none: must be random, mt1");
  EXPECT_EQ(complaint(0, "environment.placements", "benchmark"),
            "environment.placements is benchmark, and push is none: must be random, mt1 or fixed");
  EXPECT_EQ(complaint(0, "policy.heads_by", "task"),
            "policy.heads_by is not time: that takes several tasks");
  EXPECT_EQ(complaint(65, "seed", "1"), "environment.task names 65 tasks: must be at most 64");
}

TEST(ValidateTest, PeersAreTakenAndMalformedListsRefused) {
  for (const std::string peers : {"lan", "10.0.0.1", "10.0.0.1,node-7:7412", "node7"}) {
    ExpectAccepted("runtime.network", peers);
  }
  for (const std::string peers : {"", ",", "10.0.0.1,", "10.0.0.1,,10.0.0.2", "a b", "Loopback"}) {
    EXPECT_TRUE(ComplaintOf("runtime.network", peers).starts_with("runtime.network is ")) << peers;
  }
}

TEST(ValidateTest, MetricsAreShownAtAPortOfOnesChoice) {
  for (const std::string address : {"", "0", "9464", "65535", "0.0.0.0:9464", "127.0.0.1:0"}) {
    ExpectAccepted("runtime.metrics", address);
  }
  for (const std::string address : {"65536", "-1", "+1", "a", ":9464", "host:9464", "10.0.0:9464",
                                    "10.0.0.1:", "10.0.0.1:9464:1", "::1:9464", " 9464"}) {
    EXPECT_TRUE(ComplaintOf("runtime.metrics", address).starts_with("runtime.metrics is \""))
        << address;
  }
}

TEST(ValidateTest, HostsThatCannotBeAreNamedWithTheReason) {
  using testing::HasSubstr;
  struct Case {
    std::string hosts, quoted, why;
  };
  const std::string ipv6 = "IPv6 is not supported: give an IPv4 address or a host name";
  for (const std::string path : {"runtime.network", "runtime.discovery_server"}) {
    for (const Case& one : {
             Case{"::1", "'::1'", ipv6},
             {"[::1]", "'[::1]'", ipv6},
             {"10.0.0.7,[::1]:7400", "'[::1]:7400'", ipv6},
             {"fe80::1%eth0", "'fe80::1%eth0'", ipv6},
             {"2001:db8::1", "'2001:db8::1'", ipv6},
             {"[2001:db8::1]:7400", "'[2001:db8::1]:7400'", ipv6},
             {"::ffff:10.0.0.7", "'::ffff:10.0.0.7'", ipv6},
             {"udp://node-7", "'udp://node-7'", "is a URL: give HOST[:PORT] alone"},
             {"node-7,,node-8", "''", "nothing stands here"},
             {"node-7,", "''", "nothing stands here"},
             {"node-7, node-8", "' node-8'", "expected HOST[:PORT]"},
             {"lan,node-7", "'lan'", "stands alone"},
             {"node-7/24", "'node-7/24'", "expected HOST[:PORT]"},
             {"[node-7]:7400", "'[node-7]:7400'", "expected HOST[:PORT]"},
             {":7400", "':7400'", "expected HOST[:PORT]"},
             {"node-7:0", "'node-7:0'", "the port must be a number in 1..65535"},
             {"node-7:65536", "'node-7:65536'", "the port must be a number in 1..65535"},
             {"node-7:1:2", "'node-7:1:2'", "the port must be a number in 1..65535"},
         }) {
      EXPECT_THAT(ComplaintOf(path, one.hosts), HasSubstr(one.quoted + ": " + one.why));
    }
  }
}

TEST(ListenAddressTest, AnIpv6AddressIsNotSupported) {
  for (const std::string address : {"[::1]:9464", "::1", "[::]:9464", "fe80::1%eth0"}) {
    EXPECT_THAT(ComplaintOf("runtime.metrics", address),
                testing::HasSubstr("IPv6 is not supported: must be PORT or HOST:PORT"));
  }
}

TEST(ListenAddressTest, TheHostIsThisMachineAloneUnlessGiven) {
  EXPECT_EQ(text::ParseListenAddress("9464").Text(), "127.0.0.1:9464");
  EXPECT_EQ(text::ParseListenAddress("0.0.0.0:80").Text(), "0.0.0.0:80");
}

TEST(CompareForResumeTest, EverythingOutsideRuntimeForbids) {
  const RunConfig old_config = Resolve(Push());
  EXPECT_TRUE(CompareForResume(old_config, old_config, false).empty());
  VisitFields(old_config, [&](const std::string& path, const auto& owner, const auto& field) {
    RunConfig changed = old_config;
    const auto type = field.cpp_type();
    using Field = google::protobuf::FieldDescriptor;
    std::string value = "77";
    if (type == Field::CPPTYPE_ENUM) {
      const std::vector<std::string> words = EnumWords(*field.enum_type());
      value = FieldText(owner, field) == words.back() ? words.front() : words.back();
    }
    if (type == Field::CPPTYPE_BOOL) {
      value = FieldText(owner, field) == "true" ? "false" : "true";
    }
    SetField(changed, path, value);
    const auto differences = CompareForResume(old_config, changed, false);
    EXPECT_EQ(differences.size(), path.starts_with("runtime.") ? 0u : 1u) << path;
  });
}

TEST(CompareForResumeTest, DifferencesNameBothValues) {
  const RunConfig old_config = Resolve(Push());
  RunConfig changed = old_config;
  changed.mutable_ppo()->set_clip(0.1);
  EXPECT_EQ(CompareForResume(old_config, changed, false).at(0),
            "ppo.clip: the run has 0.2, asked for 0.1");
}

TEST(CompareForResumeTest, AnotherTotalIsAllowedOnlyWhenAskedFor) {
  const RunConfig old_config = Resolve(Push());
  RunConfig changed = old_config;
  changed.set_total_steps(4000000);
  EXPECT_EQ(CompareForResume(old_config, changed, false).at(0),
            "total_steps: the run has 3000000, asked for 4000000 (the learning rate depends on it; "
            "--new-total allows it)");
  EXPECT_TRUE(CompareForResume(old_config, changed, true).empty());
  changed.set_seed(9);
  EXPECT_EQ(CompareForResume(old_config, changed, true).size(), 1u);
}

TEST(CheckRunNameTest, NamesAreSafeAsFolderAndPartition) {
  for (const std::string name : {"a", "push-1", "2024.11_x"}) EXPECT_NO_THROW(CheckRunName(name));
  for (const std::string name : {"", ".", "..", "a/b", "a*", "a b", "-a", "caf\xc3\xa9"}) {
    EXPECT_THROW(CheckRunName(name), ConfigError) << name;
  }
  EXPECT_THROW(CheckRunName(std::string(65, 'a')), ConfigError);
}

class ConfigDraftTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(path_) << "environment { task: \"push-v3\" }\npolicy { hidden: 8 hidden: 8 }\n"
                            "seed: 5\nppo { clip: 0.3\n  learning_rate: 1e-3 }\n";
  }
  void TearDown() override { std::filesystem::remove(path_); }
  const std::string path_ =
      ::testing::TempDir() + "metronome_draft_" + std::to_string(getpid()) + ".cfg";
};

TEST_F(ConfigDraftTest, LaterSourcesOverrideEarlierOnes) {
  ConfigDraft draft;
  draft.ReadFile(path_);
  draft.SetFromArgument("ppo.clip=0.25");
  draft.SetFromArgument("seed=6");
  draft.Set("seed", "7", "--seed");
  const RunConfig config = draft.Finish(test::Describe);
  EXPECT_EQ(config.environment().task(), "push");
  EXPECT_EQ(config.ppo().learning_rate(), 1e-3);
  EXPECT_EQ(config.ppo().clip(), 0.25);
  EXPECT_EQ(config.seed(), 7u);
}

TEST_F(ConfigDraftTest, LaterFilesOverrideEarlierOnes) {
  const std::string later = path_ + ".later";
  std::ofstream(later) << "policy { hidden: 4 }\nppo { clip: -1 }\ncollection { overlap: 1 }\n";
  ConfigDraft draft;
  draft.ReadFile(path_);
  draft.ReadFile(later);
  const std::string error = ErrorOf([&] { static_cast<void>(draft.Finish(test::Describe)); });
  EXPECT_NE(error.find(later + ":2:7: ppo.clip is -1"), std::string::npos) << error;
  draft.SetFromArgument("ppo.clip=0.25");
  const RunConfig config = draft.Finish(test::Describe);
  EXPECT_EQ(config.seed(), 5u);
  EXPECT_EQ(config.ppo().learning_rate(), 1e-3);
  EXPECT_EQ(config.ppo().clip(), 0.25);
  EXPECT_EQ(config.collection().overlap(), 1);
  ASSERT_EQ(config.policy().hidden_size(), 1);  // a list is replaced, not added to
  EXPECT_EQ(config.policy().hidden(0), 4);
  draft.ReadFile(path_);  // whichever comes last
  EXPECT_EQ(draft.Finish(test::Describe).policy().hidden_size(), 2);
  std::filesystem::remove(later);
}

TEST_F(ConfigDraftTest, FilesOfTwoAlgorithmsAreRefused) {
  const std::string later = path_ + ".later";
  std::ofstream(later) << "custom { name: \"x\" }\n";
  ConfigDraft draft;
  draft.ReadFile(path_);
  EXPECT_EQ(
      ErrorOf([&] { draft.ReadFile(later); }),
      later + ":1:10: custom is set, and ppo at " + path_ + ":4:7: a run learns by one of the two");
  std::filesystem::remove(later);
}

TEST_F(ConfigDraftTest, AListInAFileReplacesTheRunsOwn) {
  ConfigDraft draft(Resolve(Push()));
  draft.ReadFile(path_);
  EXPECT_EQ(draft.Finish(test::Describe).policy().hidden_size(), 2);
  EXPECT_EQ(draft.Finish(test::Describe).policy().hidden(0), 8);
}

TEST_F(ConfigDraftTest, ComplaintsNameTheSourceOfTheValue) {
  std::ofstream(path_, std::ios::app) << "collection {\n  overlap: 3\n}\n";
  ConfigDraft draft;
  draft.ReadFile(path_);
  draft.Set("policy.heads", "0", "--heads");
  draft.SetFromArgument("ppo.clip=-1");
  const std::string error = ErrorOf([&] { static_cast<void>(draft.Finish(test::Describe)); });
  EXPECT_NE(error.find(path_ + ":7:3: collection.overlap is 3"), std::string::npos) << error;
  EXPECT_NE(error.find("--heads: policy.heads is 0"), std::string::npos) << error;
  EXPECT_NE(error.find("--set: ppo.clip is -1"), std::string::npos) << error;
}

TEST_F(ConfigDraftTest, TypeErrorsNameTheSourceToo) {
  ConfigDraft draft;
  EXPECT_EQ(ErrorOf([&] { draft.Set("seed", "-1", "--seed"); }),
            "--seed: seed is \"-1\": must be an integer from 0 to 18446744073709551615");
  EXPECT_EQ(ErrorOf([&] { draft.SetFromArgument("seed"); }),
            "--set seed: must be NAME=VALUE, e.g. ppo.learning_rate=3e-4");
}

}  // namespace
}  // namespace metronome::config
