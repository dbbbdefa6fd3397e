#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "actor/metaworld/tasks/environments.h"
#include "actor/options.h"
#include "common/kernels/isa.h"

namespace metronome::actor {
namespace {

class ActorOptionsTest : public ::testing::Test {
 protected:
  /// Parses `metronome-actor ARGUMENTS`; what it says on standard error goes to err_.
  std::variant<ActorCommand, int> Parse(const std::vector<std::string>& arguments) {
    std::vector<const char*> argv = {"metronome-actor"};
    for (const auto& argument : arguments) argv.push_back(argument.c_str());
    ::testing::internal::CaptureStderr();
    auto parsed = ParseActorCommand(static_cast<int>(argv.size()), argv.data(), registry_);
    err_ = ::testing::internal::GetCapturedStderr();
    return parsed;
  }

  template <class Options>
  Options Take(const std::vector<std::string>& arguments) {
    const auto parsed = Parse(arguments);
    if (std::holds_alternative<int>(parsed)) {
      ADD_FAILURE() << err_;
      return {};
    }
    return std::get<Options>(std::get<ActorCommand>(parsed));
  }

  /// Expects that the option's value is refused with exit status 2, both named.
  void ExpectRefused(std::vector<std::string> command, const std::string& option,
                     const std::string& value) {
    command.insert(command.end(), {option, value});
    const auto parsed = Parse(command);
    ASSERT_TRUE(std::holds_alternative<int>(parsed)) << command.front() << " " << option << value;
    EXPECT_EQ(std::get<int>(parsed), 2);
    EXPECT_NE(err_.find(option), std::string::npos) << err_;
    EXPECT_NE(err_.find('"' + value + '"'), std::string::npos) << err_;
  }

  const environment::EnvironmentRegistry registry_{metaworld::tasks::Environments()};
  std::string err_;
};

const std::vector<std::string> kRun = {"run", "--run", "demo"};
const std::vector<std::string> kPlacements = {"placements", "--task", "push", "--mode", "random"};
const std::vector<std::string> kEvaluate = {"evaluate", "--checkpoint", "a.ckpt"};
const std::vector<std::string> kRender = {"render", "--checkpoint", "a.ckpt", "--out", "a.png"};

TEST_F(ActorOptionsTest, WholeNumbersNeitherWrapAroundNorChangeTheirBase) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> options = {
      {kRun, "--domain"},          {kRun, "--envs"},          {kPlacements, "--seed"},
      {kEvaluate, "--seed"},       {kEvaluate, "--episodes"}, {kEvaluate, "--threads"},
      {kEvaluate, "--head-order"}, {kRender, "--seed"},       {kRender, "--episode"},
      {kRender, "--every"},        {kRender, "--step"},
  };
  for (const auto& [command, option] : options) {
    for (const std::string value :
         {"99999999999999999999", "0x10", "3x", "1.5", "1e3", " 1", "+1", "-1"}) {
      if (option == "--step" && value == "-1") continue;  // the episode judges it
      ExpectRefused(command, option, value);
    }
  }
  auto counted = kPlacements;
  counted.insert(counted.end(), {"--seed", "1"});
  for (const std::string value : {"-1", "0", "1099511627777"}) {
    ExpectRefused(counted, "--count", value);
  }
  ExpectRefused(kRun, "--domain", "233");
  ExpectRefused(kRun, "--envs", "0");
  ExpectRefused(kEvaluate, "--head-order", "4294967296");
  Parse({"evaluate", "--checkpoint", "a.ckpt", "--head-order", "0,-1"});
  EXPECT_NE(err_.find("--head-order: \"-1\" must be an integer from 0 to 4294967295"),
            std::string::npos)
      << err_;
}

TEST_F(ActorOptionsTest, InstructionsAreChosenByEachCommandThatComputesAPolicy) {
  const kernels::Isa before = kernels::CurrentIsa();
  for (auto command : {kRun, kEvaluate, kRender}) {
    kernels::ChooseIsa(before);
    ExpectRefused(command, "--isa", "sse");
    EXPECT_EQ(kernels::CurrentIsa(), before);
    command.insert(command.end(), {"--isa", "scalar"});
    EXPECT_TRUE(std::holds_alternative<ActorCommand>(Parse(command))) << err_;
    EXPECT_EQ(kernels::CurrentIsa(), kernels::Isa::kScalar);
  }
  kernels::ChooseIsa(before);
}

TEST_F(ActorOptionsTest, ALeadingZeroIsNotOctal) {
  auto with = [](std::vector<std::string> command, const std::vector<std::string>& more) {
    command.insert(command.end(), more.begin(), more.end());
    return command;
  };
  EXPECT_EQ(Take<replay::PlacementsOptions>(with(kPlacements, {"--seed", "010"})).seed, 10U);
  EXPECT_EQ(Take<play::EvaluateOptions>(with(kEvaluate, {"--seed", "010"})).seed, 10U);
  EXPECT_EQ(Take<render::RenderOptions>(with(kRender, {"--seed", "010"})).seed, 10U);
  EXPECT_EQ(Take<render::RenderOptions>(with(kRender, {"--step", "010"})).step, 10);
  EXPECT_EQ(Take<JoinOptions>(with(kRun, {"--domain", "010"})).bus.domain, 10U);
  EXPECT_EQ(Take<play::EvaluateOptions>(with(kEvaluate, {"--head-order", "0,010,2"})).head_order,
            (std::vector<std::uint32_t>{0, 10, 2}));
  EXPECT_EQ(Take<play::EvaluateOptions>(with(kEvaluate, {"--seed", "18446744073709551615"})).seed,
            18446744073709551615U);
}

TEST_F(ActorOptionsTest, AFractionIsAFiniteNumberInItsRange) {
  for (const std::string value : {"nan", "inf", "-1", "1e10", "soon", "0x1p3"}) {
    ExpectRefused(kRun, "--learner-timeout", value);
  }
  for (const std::string value : {"nan", "-0.1", "1.1"}) {
    ExpectRefused(kRender, "--arm-opacity", value);
  }
  ExpectRefused(kRender, "--speed", "nan");
  EXPECT_EQ(Take<JoinOptions>({"run", "--run", "demo", "--learner-timeout", "2.5"}).learner_timeout,
            2.5);
  EXPECT_EQ(Take<JoinOptions>({"run", "--run", "demo", "--wait", "3"}).learner_timeout, 3.0);
}

TEST_F(ActorOptionsTest, ABenchmarkStandsForTaskModeAndCount) {
  const auto options =
      Take<replay::PlacementsOptions>({"placements", "--benchmark", "ml10", "--seed", "4"});
  EXPECT_EQ(options.benchmark, "ml10");
  EXPECT_EQ(options.seed, 4U);
  const std::vector<std::string> more[] = {{"--task", "push"}, {"--mode", "mt1"}, {"--count", "3"}};
  for (const auto& words : more) {
    std::vector<std::string> command = {"placements", "--benchmark", "ml10", "--seed", "4"};
    command.insert(command.end(), words.begin(), words.end());
    EXPECT_EQ(std::get<int>(Parse(command)), 2) << words.front();
    EXPECT_NE(err_.find(words.front() + " excludes --benchmark"), std::string::npos) << err_;
  }
}

TEST_F(ActorOptionsTest, PlacementsOfATaskNeedItsModeToo) {
  EXPECT_EQ(std::get<int>(Parse({"placements", "--seed", "4"})), 2);
  EXPECT_NE(err_.find("--task (or --benchmark) is required"), std::string::npos) << err_;
  EXPECT_EQ(std::get<int>(Parse({"placements", "--seed", "4", "--task", "push"})), 2);
  EXPECT_NE(err_.find("--mode is required"), std::string::npos) << err_;
}

TEST_F(ActorOptionsTest, TasksTakesNothing) {
  Take<TasksOptions>({"tasks"});
  EXPECT_EQ(std::get<int>(Parse({"tasks", "push"})), 2);
  EXPECT_NE(err_.find("unexpected argument \"push\""), std::string::npos) << err_;
}

}  // namespace
}  // namespace metronome::actor
