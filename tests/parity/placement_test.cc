#include "actor/metaworld/placement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

#include "actor/metaworld/tasks/task_table.h"
#include "common/text/number_text.h"

namespace metronome::metaworld {
namespace {

// tests/fixtures/mt1_placements.csv: the official package's, task and seed to 50 vectors.
std::map<std::pair<std::string, std::uint32_t>, std::vector<RandVec>> OfficialPlacements() {
  std::map<std::pair<std::string, std::uint32_t>, std::vector<RandVec>> placements;
  std::ifstream file(METRONOME_FIXTURES "/mt1_placements.csv");
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    std::string task, seed, field;
    std::getline(fields, task, ',');
    std::getline(fields, seed, ',');
    std::getline(fields, field, ',');  // index
    RandVec placement{};
    for (double& number : placement) {
      std::getline(fields, field, ',');
      number = text::ParseNumber<double>(field).value();
    }
    placements[{task, text::ParseNumber<std::uint32_t>(seed).value()}].push_back(placement);
  }
  return placements;
}

TEST(PlacementTest, Mt1EqualsTheOfficialBenchmarkNumberForNumber) {
  const auto official = OfficialPlacements();
  ASSERT_EQ(official.size(), 12U);
  for (const auto& [key, want] : official) {
    SCOPED_TRACE(key.first + ", seed " + std::to_string(key.second));
    EXPECT_EQ(Mt1Placements(metaworld::tasks::FindTask(key.first), key.second), want);
  }
}

/// Of the object from what the task keeps it away from.
double PlanarDistance(const TaskSpec& task, const RandVec& p) {
  const Eigen::Vector2d from = task.keep_from.value_or(Eigen::Vector2d(p[3], p[4]));
  return std::hypot(p[0] - from.x(), p[1] - from.y());
}

TEST(PlacementTest, DrawsFillTheBoxAndKeepTheLeastDistance) {
  for (const TaskSpec& task : metaworld::tasks::AllTasks()) {
    SCOPED_TRACE(task.name);
    RandVec least = task.high, most = task.low;
    for (std::uint64_t number = 0; number < 2000; ++number) {
      numbers::RandomStream stream(numbers::RandomPurpose::kTrain, 3, number,
                                   numbers::kPlacementDraw);
      const RandVec p = DrawPlacement(task, stream);
      EXPECT_GE(PlanarDistance(task, p), task.min_planar_distance);
      for (std::size_t i = 0; i < p.size(); ++i) {
        EXPECT_GE(p[i], task.low[i]);
        EXPECT_LE(p[i], task.high[i]);
        least[i] = std::min(least[i], p[i]);
        most[i] = std::max(most[i], p[i]);
      }
    }
    for (std::size_t i = 0; i < least.size(); ++i) {
      const double slack = 0.2 * (task.high[i] - task.low[i]);  // rejection thins some edges
      EXPECT_LE(least[i], task.low[i] + slack) << "component " << i;
      EXPECT_GE(most[i], task.high[i] - slack) << "component " << i;
    }
  }
}

TEST(PlacementTest, ADrawIsAFunctionOfItsStream) {
  const TaskSpec& task = metaworld::tasks::FindTask("push");
  const auto draw = [&task](std::uint64_t seed, std::uint64_t number) {
    numbers::RandomStream stream(numbers::RandomPurpose::kTrain, seed, number,
                                 numbers::kPlacementDraw);
    return DrawPlacement(task, stream);
  };
  EXPECT_EQ(draw(1, 5), draw(1, 5));
  EXPECT_NE(draw(1, 5), draw(1, 6));
  EXPECT_NE(draw(1, 5), draw(2, 5));
}

TEST(TaskTableTest, VersionSuffixesNameTheSameTask) {
  for (const TaskSpec& task : metaworld::tasks::AllTasks())
    for (const char* suffix : {"", "-v2", "-v3"})
      EXPECT_EQ(&metaworld::tasks::FindTask(task.name + suffix), &task) << suffix;
}

TEST(TaskTableTest, AnUnknownTaskIsRefusedWithTheNearMissAndTheList) {
  try {
    metaworld::tasks::FindTask("pussh");
    FAIL() << "no exception";
  } catch (const std::invalid_argument& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("pussh"), std::string::npos) << message;
    EXPECT_NE(message.find("did you mean \"push\""), std::string::npos) << message;
    for (const TaskSpec& task : metaworld::tasks::AllTasks())
      EXPECT_NE(message.find(task.name), std::string::npos) << message;
  }
  EXPECT_THROW(metaworld::tasks::FindTask("push-v4"), std::invalid_argument);
  EXPECT_THROW(metaworld::tasks::FindTask(""), std::invalid_argument);
}

}  // namespace
}  // namespace metronome::metaworld
