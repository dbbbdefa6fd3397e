#include "learner/record/progress_log.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "common/process/files.h"
#include "common/text/number_text.h"

namespace metronome::record {
namespace {

/// Metrics of an algorithm, two of them per head.
std::vector<algorithm::Metric> AlgorithmMetrics(std::size_t heads = 2) {
  std::vector<algorithm::Metric> metrics = {{"loss", "loss/all", 1e-9, ""},
                                            {"epochs", "a/epochs", std::uint64_t{10}, ""}};
  for (std::size_t head = 0; head < heads; ++head) {
    metrics.push_back({"kl_head" + std::to_string(head), "head/kl", 0.25, ""});
  }
  return metrics;
}

algorithm::UpdateReport Report(std::uint64_t version) {
  algorithm::UpdateReport report;
  report.version = version;
  report.steps = version * 8000;
  report.episodes_used = version * 16;
  report.mean_return = 1.0 / 3 + static_cast<double>(version);
  report.metrics = AlgorithmMetrics();
  return report;
}

/// Without values.
algorithm::UpdateReport Blank(std::size_t heads = 2) {
  algorithm::UpdateReport report;
  report.metrics = AlgorithmMetrics(heads);
  return report;
}

std::vector<std::string> Cells(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  return cells;
}

std::vector<std::vector<std::string>> ReadTable(const std::string& path) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream in(process::ReadFile(path));
  for (std::string line; std::getline(in, line);) rows.push_back(Cells(line));
  return rows;
}

class ProgressLogTest : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::remove(path_); }
  void TearDown() override { std::filesystem::remove(path_); }

  std::string Cell(std::size_t row, const std::string& column) const {
    const auto table = ReadTable(path_);
    const auto at = std::find(table.at(0).begin(), table.at(0).end(), column);
    if (at == table.at(0).end()) return "no column " + column;
    return table.at(row).at(static_cast<std::size_t>(at - table[0].begin()));
  }

  const std::string path_ =
      ::testing::TempDir() + "metronome_progress_" + std::to_string(getpid()) + ".csv";
};

TEST_F(ProgressLogTest, HasOneHeaderAndTheColumnsThatOthersReadByName) {
  ProgressLog(path_, Blank(), 0);
  const auto table = ReadTable(path_);
  ASSERT_EQ(table.size(), 1u);
  const std::vector<std::string> expected = {"steps",
                                             "update",
                                             "episodes",
                                             "return",
                                             "success",
                                             "success_end",
                                             "loss",
                                             "epochs",
                                             "kl_head0",
                                             "kl_head1",
                                             "fps",
                                             "wall_seconds",
                                             "wall_collect_seconds",
                                             "wall_update_seconds",
                                             "wall_idle_share",
                                             "wall_bytes_sent",
                                             "wall_bytes_received",
                                             "wall_actors",
                                             "wall_envs",
                                             "wall_episodes_reassigned"};
  EXPECT_EQ(table[0], expected);
}

TEST_F(ProgressLogTest, RowsReadBackBitForBitAsSoonAsTheyAreAppended) {
  ProgressLog log(path_, Blank(), 0);
  WallReport wall;
  wall.seconds = 4;
  algorithm::UpdateReport report = Report(125);  // 1000000 steps: written out, not 1e+06
  report.success = 0.8125;
  report.metrics.back().value = 1.2345678901234567e-9;
  log.Append(MetricsOf(report, wall));
  EXPECT_EQ(Cell(1, "steps"), "1000000");
  EXPECT_EQ(Cell(1, "update"), "125");
  EXPECT_EQ(Cell(1, "success"), "0.8125");
  EXPECT_EQ(Cell(1, "fps"), "250000");
  EXPECT_EQ(text::ParseNumber<double>(Cell(1, "return")), report.mean_return);
  EXPECT_EQ(text::ParseNumber<double>(Cell(1, "kl_head1")), 1.2345678901234567e-9);
  EXPECT_EQ(Cell(1, "epochs"), "10");
  EXPECT_EQ(ReadTable(path_)[1].size(), ReadTable(path_)[0].size());
}

TEST_F(ProgressLogTest, TwoRunsDifferInWallClockColumnsOnly) {
  const auto write = [&](double seconds) {
    std::filesystem::remove(path_);
    WallReport wall;
    wall.seconds = seconds;
    wall.bytes_sent = static_cast<std::uint64_t>(seconds);
    ProgressLog log(path_, Blank(), 0);
    log.Append(MetricsOf(Report(1), wall));
    return ReadTable(path_);
  };
  const auto one = write(3), two = write(7);
  ASSERT_EQ(one[0], two[0]);
  int differing = 0;
  for (std::size_t i = 0; i < one[0].size(); ++i) {
    if (one[1][i] == two[1][i]) continue;
    ++differing;
    EXPECT_TRUE(one[0][i] == "fps" || one[0][i].starts_with("wall_")) << one[0][i];
  }
  EXPECT_EQ(differing, 3);
}

TEST_F(ProgressLogTest, ResumingCutsBackToTheCheckpointAndGoesOnAsIfUninterrupted) {
  std::string uninterrupted;
  std::uint64_t at_two = 0;
  {
    ProgressLog log(path_, Blank(), 0);
    for (std::uint64_t version = 1; version <= 4; ++version) {
      log.Append(MetricsOf(Report(version), {}));
      if (version == 2) at_two = log.bytes();
    }
    uninterrupted = process::ReadFile(path_);
  }
  ProgressLog log(path_, Blank(), at_two);
  EXPECT_EQ(log.bytes(), at_two);
  EXPECT_EQ(ReadTable(path_).size(), 3u);
  log.Append(MetricsOf(Report(3), {}));
  log.Append(MetricsOf(Report(4), {}));
  EXPECT_EQ(process::ReadFile(path_), uninterrupted);
}

TEST_F(ProgressLogTest, AShorterFileIsKeptUpToItsLastWholeRow) {
  { ProgressLog(path_, Blank(), 0).Append(MetricsOf(Report(1), {})); }
  const std::string whole = process::ReadFile(path_);
  std::ofstream(path_, std::ios::app) << "16000,2,32";  // cut off amid a row
  ProgressLog log(path_, Blank(), whole.size() + 1000);
  EXPECT_EQ(process::ReadFile(path_), whole);
  log.Append(MetricsOf(Report(2), {}));
  EXPECT_EQ(Cell(2, "steps"), "16000");
}

TEST_F(ProgressLogTest, AMissingFileStartsAnew) {
  ProgressLog log(path_, Blank(), 5000);
  log.Append(MetricsOf(Report(9), {}));
  EXPECT_EQ(Cell(1, "update"), "9");
}

TEST_F(ProgressLogTest, RowsWaitWhileTheDiskIsFullAndAreInTheFileOnceThereIsRoom) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {  // under a limit of its own: room for the header and half a row
    signal(SIGXFSZ, SIG_IGN);
    ProgressLog log(path_, Blank(), 0);
    const auto header = log.bytes();
    const rlimit limit{header + 20, RLIM_INFINITY};
    setrlimit(RLIMIT_FSIZE, &limit);
    log.Append(MetricsOf(Report(1), {}));
    log.Append(MetricsOf(Report(2), {}));
    const bool waited = log.bytes() == header && !log.Flush() && ReadTable(path_).size() == 1;
    const rlimit room{RLIM_INFINITY, RLIM_INFINITY};
    setrlimit(RLIMIT_FSIZE, &room);
    log.Append(MetricsOf(Report(3), {}));
    _exit(waited && log.Flush() ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  ASSERT_EQ(ReadTable(path_).size(), 4u);
  for (std::size_t row = 1; row <= 3; ++row) EXPECT_EQ(Cell(row, "update"), std::to_string(row));
}

TEST(MetricsTest, WallClockColumnsAndTagsAreMarkedAlike) {
  for (const algorithm::Metric& metric : MetricsOf(Report(1), {})) {
    const bool wall = metric.column == "fps" || metric.column.starts_with("wall_");
    EXPECT_EQ(metric.tag.starts_with("wall/"), wall) << metric.column;
  }
}

TEST(FormatNumberTest, IsTheShortestTextThatReadsBack) {
  EXPECT_EQ(text::FormatNumber(0.1), "0.1");
  EXPECT_EQ(text::FormatNumber(1.0 / 3), "0.3333333333333333");
  EXPECT_EQ(text::FormatNumber(-0.0), "-0");
  EXPECT_EQ(text::FormatNumber(2), "2");
}

TEST_F(ProgressLogTest, AFileWithOtherColumnsIsNotGoneOnWith) {
  const std::string other = "steps,update,of_another_build\n8000,1,5\n";
  std::ofstream(path_) << other;
  EXPECT_THROW(ProgressLog::RequireHeader(path_, Blank()), std::invalid_argument);
  std::filesystem::remove(path_);
  ProgressLog::RequireHeader(path_, Blank());
  ProgressLog(path_, Blank(), 0).Append(MetricsOf(Report(1), {}));
  ProgressLog::RequireHeader(path_, Blank());
  EXPECT_THROW(ProgressLog::RequireHeader(path_, Blank(3)), std::invalid_argument)
      << "columns per head";
}

TEST_F(ProgressLogTest, AFileWithTheColumnNamesOfVersion01IsGoneOnWith) {
  ProgressLog(path_, Blank(), 0).Append(MetricsOf(Report(1), {}));
  std::string content = process::ReadFile(path_);
  for (const auto& [now, before] : {std::pair<std::string, std::string>{"wall_envs", "wall_slots"},
                                    {"wall_episodes_reassigned", "wall_orders_repeated"}}) {
    ASSERT_NE(content.find(now), std::string::npos) << now;
    content.replace(content.find(now), now.size(), before);
  }
  std::ofstream(path_) << content;
  ProgressLog::RequireHeader(path_, Blank());
  ProgressLog(path_, Blank(), content.size()).Append(MetricsOf(Report(2), {}));
  EXPECT_TRUE(process::ReadFile(path_).starts_with(content));
}

}  // namespace
}  // namespace metronome::record
