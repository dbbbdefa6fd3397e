#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "common/process/files.h"
#include "learner/ppo/ppo_report.h"
#include "learner/record/metrics.h"
#include "learner/sac/sac_report.h"

namespace metronome::run {
namespace {

/// Rows of the table of learner/README.md, "progress.csv", below a heading.
std::vector<std::string> TableOfReadme(const std::string& heading) {
  std::istringstream text(process::ReadFile(METRONOME_SOURCE_DIR "/learner/README.md"));
  std::vector<std::string> rows;
  bool there = false;
  bool inside = false;
  for (std::string line; std::getline(text, line);) {
    if (line == heading) there = true;
    if (there && line.starts_with("| column | TensorBoard |")) inside = true;
    if (inside && !line.starts_with("|")) break;
    if (inside && line.starts_with("| `")) rows.push_back(line);
  }
  return rows;
}

/// What these rows must be.
std::vector<std::string> RowsOf(const std::vector<algorithm::Metric>& metrics) {
  std::vector<std::string> rows;
  for (algorithm::Metric metric : metrics) {
    for (std::string* name : {&metric.column, &metric.tag}) {
      if (name->ends_with("_head0") || name->ends_with("/0")) name->back() = 'J';
    }
    rows.push_back("| `" + metric.column + "` | `" + metric.tag + "` | " + metric.meaning + " |");
  }
  return rows;
}

TEST(MetricsTableTest, TheReadmeSaysWhatEachColumnMeans) {
  algorithm::UpdateReport report;
  report.tasks.emplace_back().name = "TASK";
  report.metrics = ppo::PpoMetrics(ppo::EmptyPpoReport(1));
  EXPECT_EQ(TableOfReadme("## progress.csv"), RowsOf(record::MetricsOf(report, {})));
  EXPECT_EQ(TableOfReadme("### Of SAC"), RowsOf(sac::SacMetrics(sac::EmptySacReport(1))));
}

}  // namespace
}  // namespace metronome::run
