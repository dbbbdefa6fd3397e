#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "common/process/files.h"
#include "learner/ppo/ppo_report.h"
#include "learner/record/metrics.h"

namespace metronome::run {
namespace {

/// Rows of the table of learner/README.md, "progress.csv".
std::vector<std::string> TableOfReadme() {
  std::istringstream text(process::ReadFile(METRONOME_SOURCE_DIR "/learner/README.md"));
  std::vector<std::string> rows;
  bool inside = false;
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("| column | TensorBoard |")) inside = true;
    if (inside && !line.starts_with("|")) break;
    if (inside && line.starts_with("| `")) rows.push_back(line);
  }
  return rows;
}

TEST(MetricsTableTest, TheReadmeSaysWhatEachColumnMeans) {
  algorithm::UpdateReport report;
  report.tasks.emplace_back().name = "TASK";
  report.metrics = ppo::PpoMetrics(ppo::EmptyPpoReport(1));
  std::vector<std::string> rows;
  for (algorithm::Metric metric : record::MetricsOf(report, {})) {
    for (std::string* name : {&metric.column, &metric.tag}) {
      if (name->ends_with("_head0") || name->ends_with("/0")) name->back() = 'J';
    }
    rows.push_back("| `" + metric.column + "` | `" + metric.tag + "` | " + metric.meaning + " |");
  }
  EXPECT_EQ(TableOfReadme(), rows);
}

}  // namespace
}  // namespace metronome::run
