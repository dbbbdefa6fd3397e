#include "learner/watch/status_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/integration/dds_fixture.h"

namespace metronome::watch {
namespace {

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(StatusTextTest, TheTableHasTheRunAndALineForEachActor) {
  const std::string table = StatusTable(test::SomeLearnerStatus(3));
  EXPECT_TRUE(Contains(table, "run a-run (incarnation 3): updating, task push")) << table;
  EXPECT_TRUE(Contains(table, "2 actors with ")) << table;
  EXPECT_TRUE(Contains(table, "somewhere:0")) << table;
  EXPECT_TRUE(Contains(table, "on probation")) << table;
  EXPECT_TRUE(Contains(table, "does not answer")) << table;
  EXPECT_FALSE(Contains(table, "more")) << table;
}

TEST(StatusTextTest, ActorsThatAreNotListedAreCounted) {
  LearnerStatus status = test::SomeLearnerStatus(3);
  status.actors_total = 7;
  EXPECT_TRUE(Contains(StatusTable(status), "and 5 more\n"));
}

TEST(StatusTextTest, AnOldStatusSaysSoFirst) {
  LearnerStatus status = test::SomeLearnerStatus(3);
  status.age_seconds = 1;
  EXPECT_TRUE(StatusTable(status).starts_with("run a-run"));
  status.age_seconds = 42;
  EXPECT_TRUE(StatusTable(status).starts_with("OLD: the learner has said nothing for 42 s"));
}

TEST(StatusTextTest, JsonIsOneLineThatHoldsTheNumbers) {
  const LearnerStatus status = test::SomeLearnerStatus(3);
  const std::string text = StatusJson(status);
  EXPECT_FALSE(Contains(text, "\n"));
  const auto json = nlohmann::json::parse(text);
  EXPECT_EQ(json["state"], "updating");
  EXPECT_EQ(json["idle_share"], status.idle_share);
  EXPECT_EQ(json["actors"][1]["oldest_assignment_seconds"], 37.5);
  EXPECT_EQ(json["actors"][1]["unanswering"], true);
}

// Scripts read them, people too: the names, and their order.
TEST(StatusTextTest, JsonHasTheseNamesInThisOrder) {
  const auto json = nlohmann::ordered_json::parse(StatusJson(test::SomeLearnerStatus(3)));
  std::string names;
  for (const auto& [name, value] : json.items()) names += name + " ";
  names += "|";
  for (const auto& [name, value] : json["actors"][0].items()) names += " " + name;
  EXPECT_EQ(
      names,
      "run_name incarnation learner_id task engine host pid state age_seconds version "
      "updates_total steps total_steps mean_return success success_end fps seconds "
      "eta_seconds collect_seconds update_seconds idle_share batch_episodes "
      "episodes_per_update accepted reassigned duplicates rejected stale bytes_sent "
      "bytes_received checkpoint_version actors_total envs_total tasks actors reordered "
      "slots_total | "
      "name envs "
      "episodes_done steps_per_second accepted rejected assignments oldest_assignment_seconds "
      "silent_seconds on_probation unanswering slots orders oldest_order_seconds");
  EXPECT_EQ(json["reordered"], json["reassigned"]);
  EXPECT_EQ(json["slots_total"], json["envs_total"]);
  const auto& actor = json["actors"][1];
  EXPECT_EQ(actor["slots"], actor["envs"]);
  EXPECT_EQ(actor["orders"], actor["assignments"]);
  EXPECT_EQ(actor["oldest_order_seconds"], actor["oldest_assignment_seconds"]);
}

}  // namespace
}  // namespace metronome::watch
