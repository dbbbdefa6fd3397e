#include "learner/watch/status_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/integration/dds_fixture.h"

namespace metronome {
namespace {

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(StatusTextTest, TheTableHasTheRunAndALineForEachActor) {
  const std::string table = StatusTable(test::SomeLearnerStatus(3));
  EXPECT_TRUE(Contains(table, "run a-run (start 3): updating, task push")) << table;
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
  EXPECT_EQ(json["actors"][1]["oldest_order_seconds"], 37.5);
  EXPECT_EQ(json["actors"][1]["unanswering"], true);
}

}  // namespace
}  // namespace metronome
