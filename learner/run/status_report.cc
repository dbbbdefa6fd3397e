#include "learner/run/status_report.h"

#include <chrono>
#include <utility>

#include "learner/record/rates.h"

namespace metronome::run {

StatusReport::StatusReport(StatusFacts facts, const RunDescription& description,
                           const collect::assignments::AssignmentRules& rules)
    : length_(facts.length) {
  status_.incarnation = description.incarnation;
  status_.learner_id = description.learner_id;
  status_.run_name = description.run_name;
  status_.task = std::move(facts.task);
  status_.engine = description.engine;
  status_.host = std::move(facts.host);
  status_.pid = facts.pid;
  status_.total_steps = length_.total_steps;
  status_.episodes_per_update = rules.episodes_per_update;
}

void StatusReport::Begin(std::uint64_t version, std::uint64_t steps, double seconds_before,
                         TimePoint now) {
  status_.version = version;
  status_.steps = steps;
  status_.updates_total = length_.UpdatesAt(version, steps);
  seconds_before_ = seconds_before;
  begun_ = now;
  due_ = now;
}

void StatusReport::Updated(const algorithm::UpdateReport& report, const record::WallReport& wall) {
  status_.version = report.version;
  status_.steps = report.steps;
  status_.updates_total = length_.UpdatesAt(report.version, report.steps);
  status_.mean_return = report.mean_return;
  status_.success = report.success;
  status_.success_end = report.success_end;
  status_.tasks.clear();
  for (const algorithm::TaskReport& task : report.tasks)
    status_.tasks.push_back({task.name, task.mean_return, task.success, task.success_end});
  status_.collect_seconds = wall.collect_seconds;
  status_.update_seconds = wall.update_seconds;
  status_.idle_share = wall.idle_share;
}

// As progress.csv counts them: over all starts of the run.
void StatusReport::SetRates(TimePoint now) {
  status_.seconds = seconds_before_ + std::chrono::duration<double>(now - begun_).count();
  status_.fps = record::StepsPerSecond(status_.steps, status_.seconds);
  status_.eta_seconds = record::SecondsLeft(status_.steps, status_.total_steps, status_.fps);
}

LearnerStatus StatusReport::Make(LearnerStatus::State state, const collect::Collector& collector,
                                 const LearnerBus& bus, TimePoint now) {
  due_ = now + kPeriod;
  status_.state = state;
  SetRates(now);
  status_.batch_episodes = collector.AcceptedOf(status_.version);
  const collect::EpisodeCounts& counts = collector.counts();
  status_.accepted = counts.accepted;
  status_.reassigned = counts.reassigned;
  status_.duplicates = counts.duplicates;
  status_.rejected = counts.rejected;
  status_.stale = counts.stale;
  status_.bytes_sent = bus.bytes_sent();
  status_.bytes_received = bus.bytes_received();
  status_.actors_total = collector.roster().actors().size();
  status_.envs_total = collector.roster().envs();
  status_.actors = collector.ReportActors(now);
  return status_;
}

}  // namespace metronome::run
