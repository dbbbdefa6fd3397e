#include "actor/replay/placements.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace metronome::replay {
namespace {

/// The rows of a benchmark's table, the head first.
std::vector<std::string> RowsOf(const std::string& benchmark) {
  PlacementsOptions options;
  options.benchmark = benchmark;
  std::stringstream out;
  EXPECT_EQ(RunPlacements(options, out), 0);
  std::vector<std::string> rows;
  for (std::string row; std::getline(out, row);) rows.push_back(row);
  return rows;
}

void ExpectRectangular(const std::vector<std::string>& rows) {
  const auto commas = [](const std::string& row) {
    return std::count(row.begin(), row.end(), ',');
  };
  for (const std::string& row : rows) EXPECT_EQ(commas(row), commas(rows.front())) << row;
}

TEST(BenchmarkPlacementsTest, AnMtBenchmarkHasFiftyRowsATask) {
  const std::vector<std::string> rows = RowsOf("mt10");
  ASSERT_EQ(rows.size(), 1 + 10 * 50U);
  EXPECT_EQ(rows[0], "task,index,obj_x,obj_y,obj_z,goal_x,goal_y,goal_z");
  EXPECT_TRUE(rows[1].starts_with("reach,0,")) << rows[1];
  EXPECT_TRUE(rows[500].starts_with("window-close,49,")) << rows[500];
  EXPECT_TRUE(rows[500].ends_with(",,,")) << rows[500];  // no goal of its own
  ExpectRectangular(rows);
}

TEST(BenchmarkPlacementsTest, AnMlBenchmarkSaysWhichHalfARowIsOf) {
  const std::vector<std::string> rows = RowsOf("ml10");
  ASSERT_EQ(rows.size(), 1 + (10 + 5) * 50U);
  EXPECT_EQ(rows[0], "split,task,index,obj_x,obj_y,obj_z,goal_x,goal_y,goal_z");
  EXPECT_TRUE(rows[500].starts_with("train,basketball,49,")) << rows[500];
  EXPECT_TRUE(rows[501].starts_with("test,drawer-open,0,")) << rows[501];
  ExpectRectangular(rows);
}

TEST(BenchmarkPlacementsTest, BadOptionsLeaveTheOutputEmpty) {
  PlacementsOptions options;
  options.benchmark = "mt5";
  std::ostringstream out;
  EXPECT_EQ(RunPlacements(options, out), 2);
  options.benchmark = "ml10";
  options.seed = 4294967296;
  EXPECT_EQ(RunPlacements(options, out), 2);
  EXPECT_EQ(out.str(), "");
}

}  // namespace
}  // namespace metronome::replay
