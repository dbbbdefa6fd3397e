#include "actor/metaworld/tasks/benchmarks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <tuple>

#include "actor/metaworld/tasks/task_table.h"
#include "common/text/number_text.h"

namespace metronome::metaworld::tasks {
namespace {

using Key = std::tuple<std::string, std::string, std::uint32_t>;  // benchmark, split, seed

struct OfficialRow {
  std::string task;
  std::size_t index;
  std::vector<double> numbers;  // 6, or 3 without a goal's
};

/// tests/fixtures/benchmark_placements.csv: some of the official package's, in its order.
std::map<Key, std::vector<OfficialRow>> OfficialRows() {
  std::map<Key, std::vector<OfficialRow>> rows;
  std::ifstream file(METRONOME_FIXTURES "/benchmark_placements.csv");
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    std::string benchmark, split, seed, index, number;
    OfficialRow row;
    for (std::string* field : {&benchmark, &split, &seed, &row.task, &index})
      std::getline(fields, *field, ',');
    row.index = text::ParseNumber<std::size_t>(index).value();
    while (std::getline(fields, number, ',') && !number.empty())
      row.numbers.push_back(text::ParseNumber<double>(number).value());
    rows[{benchmark, split, text::ParseNumber<std::uint32_t>(seed).value()}].push_back(row);
  }
  return rows;
}

std::vector<std::string> WithoutRepeats(const std::vector<OfficialRow>& rows) {
  std::vector<std::string> tasks;
  for (const OfficialRow& row : rows)
    if (tasks.empty() || tasks.back() != row.task) tasks.push_back(row.task);
  return tasks;
}

TEST(BenchmarksTest, TasksAndPlacementsAreTheOfficialOnesNumberForNumber) {
  const auto official = OfficialRows();
  ASSERT_EQ(official.size(), 12U);  // 2 seeds of mt10, mt50 and of both halves of ml10, ml45
  for (const auto& [key, rows] : official) {
    const auto& [name, split, seed] = key;
    SCOPED_TRACE(name + " " + split + ", seed " + std::to_string(seed));
    const Benchmark& benchmark = FindBenchmark(name);
    const std::vector<std::string>& tasks = split == "train" ? benchmark.train : benchmark.test;
    EXPECT_EQ(tasks, WithoutRepeats(rows));
    std::map<std::string, TaskPlacements> placements;
    for (const TaskPlacements& of : BenchmarkPlacements(tasks, seed))
      placements.emplace(of.task->name, of);
    for (const OfficialRow& row : rows) {
      const TaskPlacements& of = placements.at(row.task);
      const RandVec& got = of.placements.at(row.index);
      ASSERT_EQ(row.numbers.size(), static_cast<std::size_t>(of.task->placement_size)) << row.task;
      EXPECT_TRUE(std::equal(row.numbers.begin(), row.numbers.end(), got.begin()))
          << row.task << " " << row.index;
    }
  }
}

TEST(BenchmarksTest, Mt50AndMl45AreTheWholeTable) {
  std::set<std::string> table;
  for (const TaskSpec& task : AllTasks()) table.insert(task.name);
  const Benchmark &mt50 = FindBenchmark("mt50"), &ml45 = FindBenchmark("ml45");
  EXPECT_EQ(std::set(mt50.train.begin(), mt50.train.end()), table);
  std::set both(ml45.train.begin(), ml45.train.end());
  both.insert(ml45.test.begin(), ml45.test.end());
  EXPECT_EQ(both, table);
}

TEST(BenchmarksTest, TheFirstTaskHasThePlacementsOfMt1AndOthersHaveNot) {
  const auto placements = BenchmarkPlacements({"push", "box-close"}, 3);
  EXPECT_EQ(placements[0].placements, Mt1Placements(FindTask("push"), 3));
  EXPECT_NE(placements[1].placements, Mt1Placements(FindTask("box-close"), 3));
}

TEST(BenchmarksTest, AnUnknownBenchmarkIsRefusedWithTheList) {
  try {
    FindBenchmark("mt5");
    FAIL() << "no exception";
  } catch (const std::invalid_argument& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("unknown benchmark \"mt5\""), std::string::npos) << message;
    EXPECT_NE(message.find("mt10, mt50, ml10, ml45"), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace metronome::metaworld::tasks
