#include "actor/replay/task_list.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "actor/metaworld/tasks/task_table.h"

namespace metronome::replay {
namespace {

std::vector<std::string> LinesOfTasks() {
  std::stringstream out;
  EXPECT_EQ(RunTasks(out), 0);
  std::vector<std::string> lines;
  for (std::string line; std::getline(out, line);) lines.push_back(line);
  return lines;
}

TEST(TaskListTest, ALineATaskInTheTablesOrderUnderAHead) {
  const std::vector<std::string> lines = LinesOfTasks();
  const auto& tasks = metaworld::tasks::AllTasks();
  ASSERT_EQ(lines.size(), tasks.size() + 1);
  EXPECT_TRUE(lines.front().starts_with("task ")) << lines.front();
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    const std::string& line = lines[i + 1];
    EXPECT_TRUE(line.starts_with(tasks[i].name + " ")) << line;
    EXPECT_TRUE(line.ends_with("  " + tasks[i].success)) << line;
  }
}

TEST(TaskListTest, SaysWhatATaskIsLike) {
  for (const std::string& line : LinesOfTasks()) {
    std::istringstream words(line);
    std::string task, family, numbers, any, last, mean_return;
    words >> task >> family >> numbers >> any >> last >> mean_return;
    if (task != "push") continue;
    EXPECT_EQ((std::vector{family, numbers, any, last, mean_return}),
              (std::vector<std::string>{"pushing", "6", "100%", "40%", "4136"}));
    return;
  }
  FAIL() << "no line of push";
}

TEST(TaskListTest, ColumnsAreAligned) {
  const std::vector<std::string> lines = LinesOfTasks();
  for (const std::string head : {"family", "numbers", "any", "last", "return", "success"}) {
    const std::size_t column = lines.front().find(" " + head);
    for (const std::string& line : lines) {
      EXPECT_EQ(line[column], ' ') << line;
      EXPECT_NE(line[column + 1], ' ') << line;
    }
  }
}

TEST(TaskListTest, AnOutputThatTakesNothingIsAFailure) {
  std::ostringstream out;
  out.setstate(std::ios::badbit);
  EXPECT_EQ(RunTasks(out), 1);
}

}  // namespace
}  // namespace metronome::replay
