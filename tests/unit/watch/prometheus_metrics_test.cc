#include "learner/watch/prometheus_metrics.h"

#include <gtest/gtest.h>
#include <prometheus/client_metric.h>
#include <prometheus/metric_type.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "learner/watch/status_text.h"
#include "tests/integration/dds_fixture.h"

namespace metronome::watch {
namespace {

using Labels = std::map<std::string, std::string>;

double ValueOf(const prometheus::MetricFamily& family, const prometheus::ClientMetric& sample) {
  return family.type == prometheus::MetricType::Counter ? sample.counter.value : sample.gauge.value;
}

/// The samples of all families: name, then labels, then value.
std::map<std::string, std::map<Labels, double>> Read(const LearnerStatus& status) {
  std::map<std::string, std::map<Labels, double>> read;
  for (const auto& family : PrometheusMetrics(status, 1234.5)) {
    for (const auto& sample : family.metric) {
      Labels labels;
      for (const auto& label : sample.label) labels[label.name] = label.value;
      EXPECT_TRUE(read[family.name].emplace(labels, ValueOf(family, sample)).second) << family.name;
    }
  }
  return read;
}

TEST(PrometheusMetricsTest, EveryNumberOfTheStatusIsThere) {
  const LearnerStatus status = test::SomeLearnerStatus(3);  // whose numbers all differ
  std::multiset<double> values;
  for (const auto& [name, samples] : Read(status)) {
    for (const auto& [labels, value] : samples) values.insert(value);
  }
  auto said = nlohmann::json::parse(StatusJson(status));
  for (const char* not_a_measure : {"incarnation", "learner_id", "pid"}) said.erase(not_a_measure);
  const auto expect = [&values](const std::string& name, const nlohmann::json& value) {
    if (!value.is_number()) return;
    EXPECT_TRUE(values.contains(value)) << name << " " << value;
  };
  for (const auto& [name, value] : said.items()) expect(name, value);
  for (const auto& actor : said["actors"]) {
    for (const auto& [name, value] : actor.items()) expect(name, value);
  }
}

TEST(PrometheusMetricsTest, ARunsMetricsAreLabelledByTheRun) {
  const LearnerStatus status = test::SomeLearnerStatus(3);
  auto read = Read(status);
  const Labels run = {{"run", "a-run"}};
  EXPECT_EQ(read["metronome_updates_total"].at(run), double(status.version));
  EXPECT_EQ(read["metronome_success_ratio"].at(run), status.success);
  EXPECT_EQ(read["metronome_success_at_end_ratio"].at(run), status.success_end);
  EXPECT_EQ(read["metronome_received_bytes_total"].at(run), double(status.bytes_received));
  EXPECT_EQ(read["metronome_status_timestamp_seconds"].at(run), 1234.5);
  EXPECT_EQ(read["metronome_info"].at({{"run", "a-run"},
                                       {"task", "push"},
                                       {"engine", "mujoco-0.0.0"},
                                       {"host", "here"},
                                       {"pid", "78"},
                                       {"incarnation", "3"},
                                       {"start", "3"}}),
            1);
}

TEST(PrometheusMetricsTest, TheStateIsOneOfFive) {
  auto states = Read(test::SomeLearnerStatus(3))["metronome_state"];
  EXPECT_EQ(states.size(), 5U);
  for (const auto& [labels, value] : states) {
    EXPECT_EQ(value, labels.at("state") == "updating" ? 1 : 0) << labels.at("state");
  }
}

TEST(PrometheusMetricsTest, ActorsAreLabelledByThemselvesAndTheirHost) {
  const LearnerStatus status = test::SomeLearnerStatus(3);
  const ActorReport& actor = status.actors.at(1);
  const Labels labels = {{"run", "a-run"}, {"actor", actor.name}, {"host", "somewhere"}};
  auto read = Read(status);
  EXPECT_EQ(read["metronome_actor_episodes_played_total"].at(labels), double(actor.episodes_done));
  EXPECT_EQ(read["metronome_actor_oldest_assignment_age_seconds"].at(labels), 37.5);
  EXPECT_EQ(read["metronome_actor_unanswering"].at(labels), 1);
}

TEST(PrometheusMetricsTest, RenamedNumbersKeepTheirOldNames) {
  auto read = Read(test::SomeLearnerStatus(3));
  const std::map<std::string, std::string> old_names = {
      {"metronome_slots_idle_ratio", "metronome_envs_idle_ratio"},
      {"metronome_slots", "metronome_envs"},
      {"metronome_episodes_reordered_total", "metronome_episodes_reassigned_total"},
      {"metronome_actor_slots", "metronome_actor_envs"},
      {"metronome_actor_orders", "metronome_actor_assignments"},
      {"metronome_actor_oldest_order_age_seconds",
       "metronome_actor_oldest_assignment_age_seconds"}};
  for (const auto& [old_name, name] : old_names) {
    EXPECT_FALSE(read[name].empty()) << name;
    EXPECT_EQ(read[old_name], read[name]) << old_name;
  }
}

TEST(PrometheusMetricsTest, WhoHasLeftHasNoSeries) {
  LearnerStatus status = test::SomeLearnerStatus(3);
  const std::string gone = status.actors.front().name;
  status.actors.erase(status.actors.begin());
  for (const auto& [name, samples] : Read(status)) {
    for (const auto& [labels, value] : samples) {
      const auto actor = labels.find("actor");
      EXPECT_TRUE(actor == labels.end() || actor->second != gone) << name;
    }
  }
  status.actors.clear();
  EXPECT_FALSE(Read(status).contains("metronome_actor_assignments"));
}

}  // namespace
}  // namespace metronome::watch
