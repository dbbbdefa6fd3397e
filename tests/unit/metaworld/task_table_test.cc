#include "actor/metaworld/tasks/task_table.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "actor/metaworld/tasks/environments.h"

namespace metronome::metaworld {
namespace {

TEST(EnvironmentsTest, AreTheTableByAllNamesOfATask) {
  const environment::EnvironmentRegistry registry(metaworld::tasks::Environments());
  ASSERT_EQ(registry.entries().size(), metaworld::tasks::AllTasks().size());
  for (const auto& task : metaworld::tasks::AllTasks()) {
    for (const std::string& name :
         {"metaworld/" + task.name, task.name, task.name + "-v2", task.name + "-v3"}) {
      const EnvironmentSpec spec = registry.Describe(name);
      EXPECT_EQ(spec.name(), "metaworld/" + task.name);
      EXPECT_EQ(spec.short_name(), task.name);
    }
  }
}

TEST(EnvironmentsTest, OtherNamesAreRefusedWithTheNearMissAndTheList) {
  const environment::EnvironmentRegistry registry(metaworld::tasks::Environments());
  for (const std::string name : {"push-v1", "push-v", "Push", "", "-v3", "push-v2-v3"}) {
    EXPECT_THROW(static_cast<void>(registry.Find(name)), std::invalid_argument) << name;
  }
  try {
    static_cast<void>(registry.Find("pussh"));
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_EQ(std::string(error.what())
                  .find("unknown environment \"pussh\"; did you mean \"push\"? "
                        "Known: assembly, "),
              0U)
        << error.what();
  }
}

TEST(RegistryTest, TwoEnvironmentsOfOneNameAreAMistake) {
  auto twice = metaworld::tasks::Environments();
  twice.push_back(twice.front());
  EXPECT_THROW(environment::EnvironmentRegistry(std::move(twice)), std::logic_error);
}

TEST(RegistryTest, AListIsSeveralTasksInItsOrderByTheirShortNames) {
  const environment::EnvironmentRegistry registry(metaworld::tasks::Environments());
  const EnvironmentSpec spec = registry.Describe("push-v3,metaworld/assembly");
  EXPECT_EQ(spec.short_name(), "push,assembly");
  EXPECT_EQ(std::vector<std::string>(spec.tasks().begin(), spec.tasks().end()),
            (std::vector<std::string>{"push", "assembly"}));
  EXPECT_EQ(spec.observation_size(), 39);
  EXPECT_TRUE(registry.Describe("push").tasks().empty());
  const auto refusal = [&registry](const std::string& list) {
    try {
      static_cast<void>(registry.Describe(list));
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_EQ(refusal("push,assembly,push-v2"),
            "impossible list \"push,assembly,push-v2\": push is in it twice");
  EXPECT_EQ(refusal("push,asembly").find("unknown environment \"asembly\"; did you mean"), 0U);
  EXPECT_EQ(refusal("push,").find("unknown environment \"\""), 0U);
}

TEST(RegistryTest, TasksThatNoPolicyPlaysTogetherAreRefused) {
  auto entries = metaworld::tasks::Environments();
  entries.resize(2);
  entries[1].spec.set_observation_size(7);
  const environment::EnvironmentRegistry registry(entries);
  const std::string both = entries[0].spec.short_name() + "," + entries[1].spec.short_name();
  EXPECT_THROW(static_cast<void>(registry.Describe(both)), std::invalid_argument);
}

TEST(RegistryTest, AGroupIsItsTasksUnderOneName) {
  const environment::EnvironmentRegistry registry(metaworld::tasks::Environments(), {},
                                                  {{"two", {"push", "assembly"}, true}});
  const EnvironmentSpec spec = registry.Describe("two");
  EXPECT_EQ(spec.short_name(), "two");
  EXPECT_EQ(spec.tasks_size(), 2);
  EXPECT_TRUE(spec.has_benchmark());
  EnvironmentConfig config;
  config.set_task("two");
  *config.mutable_spec() = spec;
  EXPECT_NE(registry.Make(config, 1), nullptr);
  EXPECT_THROW(static_cast<void>(registry.Make(config, 2)), std::out_of_range);
}

TEST(RegistryTest, AnotherEnvironmentOfThatNameIsNotTheRuns) {
  const environment::EnvironmentRegistry registry(metaworld::tasks::Environments());
  EnvironmentConfig config;
  config.set_task("push");
  *config.mutable_spec() = registry.Describe("push");
  config.mutable_spec()->set_max_steps(499);
  EXPECT_THROW(static_cast<void>(registry.Make(config)), std::invalid_argument);
}

}  // namespace
}  // namespace metronome::metaworld
