#include "learner/watch/prometheus_metrics.h"

#include <prometheus/client_metric.h>
#include <prometheus/metric_type.h>

#include <string>
#include <string_view>
#include <utility>

#include "learner/watch/old_names.h"

namespace metronome::watch {
namespace {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using Labels = std::vector<ClientMetric::Label>;

constexpr auto kCounter = prometheus::MetricType::Counter;
constexpr auto kGauge = prometheus::MetricType::Gauge;

// By the convention of Prometheus, which its promtool checks, a counter's name tells that it is
// one.
prometheus::MetricType TypeOf(const StatusNumber& number) {
  return std::string_view(number.metric).ends_with("_total") ? kCounter : kGauge;
}

ClientMetric Sample(Labels labels, prometheus::MetricType type, double value) {
  ClientMetric sample;
  sample.label = std::move(labels);
  (type == kCounter ? sample.counter.value : sample.gauge.value) = value;
  return sample;
}

MetricFamily Family(const StatusNumber& number, std::vector<ClientMetric> samples) {
  return {number.metric, number.help, TypeOf(number), std::move(samples)};
}

/// The same samples under the name that they had before.
void AddOldName(const OldName* old_name, std::vector<MetricFamily>& families) {
  if (old_name == nullptr) return;
  MetricFamily old = families.back();
  old.help = "Old name of " + old.name + ".";
  old.name = old_name->old_metric;
  families.push_back(std::move(old));
}

MetricFamily Gauges(const char* name, const char* help, std::vector<ClientMetric> samples) {
  return {name, help, kGauge, std::move(samples)};
}

Labels LabelsOf(const LearnerStatus& status, const ActorReport& actor) {
  return {{"run", status.run_name}, {"actor", actor.name}, {"host", HostOfName(actor.name)}};
}

/// 1 for the state that it is in, 0 for the others.
MetricFamily States(const LearnerStatus& status) {
  std::vector<ClientMetric> samples;
  for (int i = 0; i <= static_cast<int>(LearnerState::kStopped); ++i) {
    const auto state = static_cast<LearnerState>(i);
    samples.push_back(Sample({{"run", status.run_name}, {"state", StateText(state)}}, kGauge,
                             state == status.state ? 1 : 0));
  }
  return Gauges("metronome_state", "1 for the learner's state, 0 for the others.",
                std::move(samples));
}

MetricFamily Info(const LearnerStatus& status) {
  return Gauges("metronome_info", "1, and who this is.",
                {Sample({{"run", status.run_name},
                         {"task", status.task},
                         {"engine", status.engine},
                         {"host", status.host},
                         {"pid", std::to_string(status.pid)},
                         {"incarnation", std::to_string(status.incarnation)},
                         {"start", std::to_string(status.incarnation)}},
                        kGauge, 1)});
}

void AddTasks(const LearnerStatus& status, std::vector<MetricFamily>& families) {
  VisitTaskNumbers([&](const StatusNumber& number, auto member) {
    std::vector<ClientMetric> samples;
    for (const TaskStatus& task : status.tasks) {
      const Labels labels = {{"run", status.run_name}, {"task", task.name}};
      samples.push_back(Sample(labels, TypeOf(number), task.*member));
    }
    families.push_back(Family(number, std::move(samples)));
  });
}

}  // namespace

std::vector<MetricFamily> PrometheusMetrics(const LearnerStatus& status, double made_at) {
  const Labels run = {{"run", status.run_name}};
  std::vector<MetricFamily> families = {
      Info(status), States(status),
      Gauges("metronome_status_timestamp_seconds", "When the learner said all this, Unix time.",
             {Sample(run, kGauge, made_at)})};
  VisitRunNumbers([&](const StatusNumber& number, auto member) {
    const auto value = static_cast<double>(status.*member);
    families.push_back(Family(number, {Sample(run, TypeOf(number), value)}));
    AddOldName(FindOldName(kOldRunNames, number.name), families);
  });
  if (!status.tasks.empty()) AddTasks(status, families);
  if (status.actors.empty()) return families;
  VisitActorNumbers([&](const StatusNumber& number, auto member) {
    std::vector<ClientMetric> samples;
    for (const ActorReport& actor : status.actors) {
      const auto value = static_cast<double>(actor.*member);
      samples.push_back(Sample(LabelsOf(status, actor), TypeOf(number), value));
    }
    families.push_back(Family(number, std::move(samples)));
    AddOldName(FindOldName(kOldActorNames, number.name), families);
  });
  return families;
}

}  // namespace metronome::watch
