#include "learner/sac/trainer.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "common/numbers/all_finite.h"
#include "common/policy/network.h"
#include "common/policy/snapshot.h"
#include "common/policy/task_of.h"
#include "learner/algorithm/algorithm.h"
#include "learner/network/running_statistics.h"
#include "learner/network/worker_team.h"
#include "learner/sac/draw_batch.h"
#include "learner/sac/gradient_step.h"
#include "learner/sac/replay.h"
#include "learner/sac/schedules.h"

namespace metronome::sac {

struct Trainer::Impl {
  Impl(const RunConfig& run_config, SacState initial, int threads)
      : config(run_config),
        state(std::move(initial)),
        team(threads),
        step(config, team),
        replay(config) {}

  // Everything of the next state but what gradient steps change: counters and statistics.
  [[nodiscard]] SacState After(const std::vector<Episode>& batch) const {
    SacState next = state;
    if (config.collection().overlap() > 0) {
      next.previous_actor = state.optimiser.actor;
      next.previous_observation = state.observation;
    }
    const auto observations = std::size_t(policy::ShapeOf(config).observation);
    for (const Episode& episode : batch) {
      network::Merge(next.observation[policy::TaskOf(config, episode.number)],
                     episode.observation.data(), std::size_t(episode.length()), observations,
                     observations);
    }
    static_cast<checkpoint::RunCounters&>(next) = algorithm::CountersAfter(state, batch);
    return next;
  }

  // The gradient steps that have become due, under the statistics of `next`.
  void Learn(SacState& next, SacReport& report) {
    const PolicySnapshot normaliser = SnapshotOf(next, config);
    step.Begin(next.optimiser);
    const std::uint64_t due = GradientStepsDue(next.steps, config);
    while (next.optimiser.gradient_steps < due) {
      const auto batch = DrawBatch(replay, config, next.optimiser.gradient_steps);
      Add(step.Run(batch, normaliser, next.optimiser), report);
    }
  }

  static void Add(const StepFigures& figures, SacReport& report) {
    ++report.gradient_steps;
    report.critic_loss += figures.critic_loss;
    report.actor_loss += figures.actor_loss;
    report.critic_gradient_norm += figures.critic_gradient_norm;
    report.actor_gradient_norm += figures.actor_gradient_norm;
    for (std::size_t head = 0; head < figures.heads.size(); ++head) {
      report.head_samples[head] += figures.heads[head].samples;
      report.head_entropy[head] += figures.heads[head].entropy;
      report.head_value[head] += figures.heads[head].value;
    }
  }

  RunConfig config;
  SacState state;
  network::WorkerTeam team;
  GradientStep step;
  Replay replay;
};

Trainer::Trainer(const RunConfig& config, SacState state, const std::vector<Episode>& replay,
                 int threads)
    : impl_(std::make_unique<Impl>(config, std::move(state), threads)) {
  for (const Episode& episode : replay) impl_->replay.Add(episode);
}

Trainer::~Trainer() = default;

const SacState& Trainer::state() const { return impl_->state; }

SacReport Trainer::Update(const std::vector<Episode>& batch) {
  Impl& impl = *impl_;
  SacState next = impl.After(batch);
  for (const Episode& episode : batch) impl.replay.Add(episode);
  SacReport report = EmptySacReport(next.optimiser.log_temperature.size());
  impl.Learn(next, report);
  for (const auto* weights : {&next.optimiser.actor, &next.optimiser.critics}) {
    if (!numbers::AllFinite(*weights))
      throw algorithm::NonFiniteUpdate("a parameter is not finite");
  }
  // Finite weights may still give actions that are not: no actor would play another episode.
  if (const auto defect = policy::SnapshotDefect(SnapshotOf(next, impl.config), impl.config)) {
    throw algorithm::NonFiniteUpdate("no actor can act with the new policy: " + *defect);
  }
  Finish(next.optimiser.log_temperature, impl.replay.steps(), report);
  static_cast<algorithm::UpdateReport&>(report) = algorithm::ReportOf(impl.config, next, batch);
  impl.state = std::move(next);
  return report;
}

}  // namespace metronome::sac
