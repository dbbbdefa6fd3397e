#include "learner/watch/prometheus_metrics.h"

#include <prometheus/client_metric.h>
#include <prometheus/metric_type.h>

#include <string>
#include <utility>

namespace metronome {
namespace {

using prometheus::ClientMetric;
using prometheus::MetricFamily;
using Labels = std::vector<ClientMetric::Label>;

constexpr auto kCounter = prometheus::MetricType::Counter;
constexpr auto kGauge = prometheus::MetricType::Gauge;

/// One metric, from a member of Owner.
template <class Owner>
struct Metric {
  const char* name;
  prometheus::MetricType type;
  const char* help;
  double (*value)(const Owner&);
};

template <auto Member>
constexpr auto kMember = [](const auto& owner) { return static_cast<double>(owner.*Member); };

using Status = LearnerStatus;
constexpr Metric<Status> kRunMetrics[] = {
    {"metronome_updates_total", kCounter, "Updates made.", kMember<&Status::version>},
    {"metronome_updates_planned", kGauge, "Updates of the whole run.",
     kMember<&Status::updates_total>},
    {"metronome_steps_total", kCounter, "Steps of the environment learnt from.",
     kMember<&Status::steps>},
    {"metronome_steps_planned", kGauge, "Steps of the whole run.", kMember<&Status::total_steps>},
    {"metronome_return", kGauge, "Mean return of the last update's episodes.",
     kMember<&Status::mean_return>},
    {"metronome_success_ratio", kGauge, "Episodes of the last update with success at any step.",
     kMember<&Status::success>},
    {"metronome_success_at_end_ratio", kGauge,
     "Episodes of the last update with success at their last step.", kMember<&Status::success_end>},
    {"metronome_steps_per_second", kGauge, "Steps a second since the run began.",
     kMember<&Status::fps>},
    {"metronome_run_duration_seconds", kGauge, "What the run has taken, all starts together.",
     kMember<&Status::seconds>},
    {"metronome_run_remaining_seconds", kGauge, "What the run will still take; 0 while unknown.",
     kMember<&Status::eta_seconds>},
    {"metronome_collect_duration_seconds", kGauge, "Collecting the last update's episodes took.",
     kMember<&Status::collect_seconds>},
    {"metronome_update_duration_seconds", kGauge, "Learning from them took.",
     kMember<&Status::update_seconds>},
    {"metronome_slots_idle_ratio", kGauge, "Of the actors' time during the last update.",
     kMember<&Status::idle_share>},
    {"metronome_batch_episodes", kGauge, "Episodes here of the batch that is collected.",
     kMember<&Status::batch_episodes>},
    {"metronome_batch_episodes_wanted", kGauge, "Episodes of an update.",
     kMember<&Status::episodes_per_update>},
    {"metronome_episodes_accepted_total", kCounter, "Episodes that passed the check.",
     kMember<&Status::accepted>},
    {"metronome_episodes_reordered_total", kCounter, "Episodes that were ordered again.",
     kMember<&Status::reordered>},
    {"metronome_episodes_duplicate_total", kCounter, "Episodes that came again.",
     kMember<&Status::duplicates>},
    {"metronome_episodes_rejected_total", kCounter, "Episodes that failed the check.",
     kMember<&Status::rejected>},
    {"metronome_episodes_stale_total", kCounter, "Episodes of an earlier start of the learner.",
     kMember<&Status::stale>},
    {"metronome_sent_bytes_total", kCounter, "Payload sent.", kMember<&Status::bytes_sent>},
    {"metronome_received_bytes_total", kCounter, "Payload received.",
     kMember<&Status::bytes_received>},
    {"metronome_checkpoint_version", kGauge, "Updates in the newest checkpoint on disk.",
     kMember<&Status::checkpoint_version>},
    {"metronome_actors", kGauge, "Actors connected.", kMember<&Status::actors_total>},
    {"metronome_slots", kGauge, "Episodes that they play at once.", kMember<&Status::slots_total>},
};

constexpr Metric<ActorReport> kActorMetrics[] = {
    {"metronome_actor_slots", kGauge, "Episodes that the actor plays at once.",
     kMember<&ActorReport::slots>},
    {"metronome_actor_episodes_played_total", kCounter,
     "Episodes that it has played, for all learners that it served.",
     kMember<&ActorReport::episodes_done>},
    {"metronome_actor_steps_per_second", kGauge, "Its speed, as it says.",
     kMember<&ActorReport::steps_per_second>},
    {"metronome_actor_episodes_accepted_total", kCounter, "Its episodes that passed the check.",
     kMember<&ActorReport::accepted>},
    {"metronome_actor_episodes_rejected_total", kCounter, "Its episodes that failed the check.",
     kMember<&ActorReport::rejected>},
    {"metronome_actor_orders", kGauge, "Orders that it has not answered.",
     kMember<&ActorReport::orders>},
    {"metronome_actor_oldest_order_age_seconds", kGauge, "Age of the oldest of them; 0 without.",
     kMember<&ActorReport::oldest_order_seconds>},
    {"metronome_actor_status_age_seconds", kGauge, "Since its last word.",
     kMember<&ActorReport::silent_seconds>},
    {"metronome_actor_on_probation", kGauge,
     "1 if its host's actors come and go, and others are preferred.",
     kMember<&ActorReport::on_probation>},
    {"metronome_actor_unanswering", kGauge,
     "1 if it gave up an order and has brought nothing since.", kMember<&ActorReport::unanswering>},
};

ClientMetric Sample(Labels labels, prometheus::MetricType type, double value) {
  ClientMetric sample;
  sample.label = std::move(labels);
  (type == kCounter ? sample.counter.value : sample.gauge.value) = value;
  return sample;
}

MetricFamily Family(const char* name, prometheus::MetricType type, const char* help,
                    std::vector<ClientMetric> samples) {
  return {name, help, type, std::move(samples)};
}

Labels LabelsOf(const LearnerStatus& status, const ActorReport& actor) {
  return {{"run", status.run_name}, {"actor", actor.name}, {"host", HostOfName(actor.name)}};
}

/// 1 for the state that it is in, 0 for the others.
MetricFamily States(const LearnerStatus& status) {
  std::vector<ClientMetric> samples;
  for (int i = 0; i <= static_cast<int>(Status::State::kStopped); ++i) {
    const auto state = static_cast<Status::State>(i);
    samples.push_back(Sample({{"run", status.run_name}, {"state", StateText(state)}}, kGauge,
                             state == status.state ? 1 : 0));
  }
  return Family("metronome_state", kGauge, "1 for the learner's state, 0 for the others.",
                std::move(samples));
}

MetricFamily Info(const LearnerStatus& status) {
  return Family("metronome_info", kGauge, "1, and who this is.",
                {Sample({{"run", status.run_name},
                         {"task", status.task},
                         {"engine", status.engine},
                         {"host", status.host},
                         {"pid", std::to_string(status.pid)},
                         {"start", std::to_string(status.incarnation)}},
                        kGauge, 1)});
}

}  // namespace

std::vector<MetricFamily> PrometheusMetrics(const LearnerStatus& status, double made_at) {
  const Labels run = {{"run", status.run_name}};
  std::vector<MetricFamily> families = {
      Info(status), States(status),
      Family("metronome_status_timestamp_seconds", kGauge,
             "When the learner said all this, Unix time.", {Sample(run, kGauge, made_at)})};
  for (const auto& [name, type, help, value] : kRunMetrics) {
    families.push_back(Family(name, type, help, {Sample(run, type, value(status))}));
  }
  if (status.actors.empty()) return families;
  for (const auto& [name, type, help, value] : kActorMetrics) {
    std::vector<ClientMetric> samples;
    for (const ActorReport& actor : status.actors) {
      samples.push_back(Sample(LabelsOf(status, actor), type, value(actor)));
    }
    families.push_back(Family(name, type, help, std::move(samples)));
  }
  return families;
}

}  // namespace metronome
