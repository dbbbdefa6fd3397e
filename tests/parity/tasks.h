#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "actor/metaworld/tasks/task_table.h"

/// Every task of the table is tested: INSTANTIATE_TEST_SUITE_P(Tasks, Suite, EachTask(), TestName).
namespace metronome::metaworld {

inline auto EachTask() {
  std::vector<std::string> names;
  for (const TaskSpec& task : metaworld::tasks::AllTasks()) names.push_back(task.name);
  return testing::ValuesIn(names);
}

inline std::string TestName(const testing::TestParamInfo<std::string>& task) {
  std::string name = task.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

}  // namespace metronome::metaworld
