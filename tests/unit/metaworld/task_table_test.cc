#include "actor/metaworld/tasks/task_table.h"

#include <gtest/gtest.h>

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
