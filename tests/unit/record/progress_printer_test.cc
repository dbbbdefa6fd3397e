#include "learner/record/progress_printer.h"

#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <ostream>
#include <sstream>
#include <string>

namespace metronome::record {
namespace {

RunFacts Facts() {
  RunFacts facts;
  facts.run = "name";
  facts.path = "runs/name";
  facts.incarnation = 2;
  facts.length = {8000, 10, false};
  facts.episodes_per_update = 16;
  facts.network = "loopback";
  facts.transport = "udp";
  return facts;
}

algorithm::UpdateReport Report() {
  algorithm::UpdateReport report;
  report.version = 4;
  report.steps = 2000;
  report.mean_return = 12.5;
  report.success = 0.75;
  report.success_end = 0.5;
  return report;
}

WallReport Wall() {
  WallReport wall;
  wall.seconds = 4;
  wall.actors = 3;
  wall.envs = 6;
  wall.idle_share = 0.25;
  return wall;
}

std::function<void(std::string)> To(std::ostream& out) {
  return [&out](const std::string& line) { out << line; };
}

TEST(ProgressPrinterTest, JsonTellsEachUpdateInOneLineWithStableKeys) {
  std::ostringstream out;
  ProgressPrinter(ProgressStyle::kJson, Facts(), To(out)).Updated(Report(), Wall());
  EXPECT_EQ(
      out.str(),
      "{\"update\":4,\"updates_total\":10,\"steps\":2000,\"total_steps\":8000,\"return\":12.5,"
      "\"success\":0.75,\"success_end\":0.5,\"fps\":500.0,\"seconds\":4.0,"
      "\"eta_seconds\":12.0,\"actors\":3,\"envs\":6,\"idle_share\":0.25}\n");
}

TEST(ProgressPrinterTest, JsonEventsNameTheirKindAndWhatALauncherNeeds) {
  std::ostringstream out;
  ProgressPrinter printer(ProgressStyle::kJson, Facts(), To(out));
  printer.Started(4, 2000);
  printer.Finished("all of it", "runs/name/checkpoints/000010.ckpt", "abc");
  printer.Interrupted(5, "runs/name/checkpoints/000005.ckpt");
  std::istringstream in(out.str());
  std::string line;
  std::getline(in, line);
  auto record = nlohmann::json::parse(line);
  EXPECT_EQ(record.at("event"), "started");
  EXPECT_EQ(record.at("incarnation"), 2);
  EXPECT_EQ(record.at("domain"), 0);
  EXPECT_EQ(record.at("episodes_per_update"), 16);
  EXPECT_EQ(record.at("transport"), "udp");
  std::getline(in, line);
  record = nlohmann::json::parse(line);
  EXPECT_EQ(record.at("event"), "finished");
  EXPECT_EQ(record.at("accounting"), "all of it");
  EXPECT_EQ(record.at("weights_sha256"), "abc");
  std::getline(in, line);
  record = nlohmann::json::parse(line);
  EXPECT_EQ(record.at("event"), "interrupted");
  EXPECT_EQ(record.at("update"), 5);
}

TEST(ProgressPrinterTest, APathThatIsNotUtf8IsOneJsonLine) {
  RunFacts facts = Facts();
  facts.path = "runs/caf\xe9";
  std::ostringstream out;
  ProgressPrinter(ProgressStyle::kJson, facts, To(out)).Started(0, 0);
  EXPECT_EQ(nlohmann::json::parse(out.str()).at("path"), "runs/caf\uFFFD");
}

TEST(ProgressPrinterTest, LinesAreForPeopleAndNoneIsSilent) {
  std::ostringstream lines;
  ProgressPrinter(ProgressStyle::kLines, Facts(), To(lines)).Updated(Report(), Wall());
  EXPECT_NE(lines.str().find("4/10"), std::string::npos) << lines.str();
  EXPECT_NE(lines.str().find("3 actors  0:00:12 left"), std::string::npos) << lines.str();
  WallReport alone = Wall();
  alone.actors = 1;
  ProgressPrinter(ProgressStyle::kLines, Facts(), To(lines)).Updated(Report(), alone);
  EXPECT_NE(lines.str().find("1 actor  0:00:12 left"), std::string::npos) << lines.str();
  std::ostringstream none;
  ProgressPrinter printer(ProgressStyle::kNone, Facts(), To(none));
  printer.Started(0, 0);
  printer.Updated(Report(), Wall());
  printer.Finished("x", "y", "z");
  printer.Interrupted(1, "y");
  EXPECT_EQ(none.str(), "");
}

}  // namespace
}  // namespace metronome::record
