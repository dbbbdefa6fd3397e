#include "actor/metaworld/tasks/task_table.h"

#include <gtest/gtest.h>

#include "common/config/task_names.h"

namespace metronome {
namespace {

TEST(TaskTableTest, HasExactlyTheTasksWhoseNamesTheLearnerKnows) {
  std::vector<std::string> names;
  for (const auto& task : metaworld::AllTasks()) names.push_back(task.name);
  EXPECT_EQ(names, TaskNames());
}

TEST(TaskTableTest, TakesTheSpellingsThatTheConfigurationTakes) {
  for (const auto& task : metaworld::AllTasks()) {
    for (const std::string suffix : {"", "-v2", "-v3"}) {
      EXPECT_EQ(metaworld::FindTask(task.name + suffix).name,
                CanonicalTaskName(task.name + suffix));
    }
  }
}

}  // namespace
}  // namespace metronome
