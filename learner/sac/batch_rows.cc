#include "learner/sac/batch_rows.h"

#include <algorithm>

#include "common/messages/episode.h"

namespace metronome::sac {

BatchRows::BatchRows(const RunConfig& config)
    : networks_(config),
      horizon_(config.environment().horizon()),
      clip_(float(config.policy().observation_clip())),
      samples_(std::size_t(config.sac().batch())) {
  for (kernels::Matrix* input : {&state, &next_state}) {
    input->Resize(samples_, std::size_t(networks_.shape.input()));
  }
  for (kernels::Matrix* input : {&played, &tried, &next}) {
    input->Resize(samples_, networks_.critic_inputs());
  }
}

void BatchRows::Take(const std::vector<Transition>& batch, const PolicySnapshot& normaliser) {
  batch_ = &batch;
  normaliser_ = {normaliser.observation_mean.data(), normaliser.observation_inv_std.data(), clip_};
}

// What actor and critic see of the state after `t` steps.
void BatchRows::WriteState(const ReplayEpisode& of, std::int32_t t, float* actor_row,
                           float* critic_row) {
  const policy::NetworkShape& shape = networks_.shape;
  policy::WriteInput(
      shape, normaliser_,
      of.episode.observation.data() + std::size_t(t) * std::size_t(shape.observation), of.task, t,
      horizon_, actor_row);
  std::copy_n(actor_row, shape.input(), critic_row);
  if (shape.critic_time) critic_row[shape.input()] = policy::Phase(t, horizon_);
}

void BatchRows::Gather(std::size_t row) {
  const Transition& transition = of(row);
  const ReplayEpisode& episode = *transition.step.of;
  WriteState(episode, transition.step.t, state.row(row), played.row(row));
  WriteState(episode, transition.next_t, next_state.row(row), next.row(row));
  std::copy_n(played.row(row), networks_.state_inputs(), tried.row(row));
  const float* action =
      episode.episode.action.data() + std::size_t(transition.step.t) * networks_.actions();
  std::copy_n(action, networks_.actions(), played.row(row) + networks_.state_inputs());
}

void BatchRows::Try(std::size_t row, const float* action) {
  std::copy_n(action, networks_.actions(), tried.row(row) + networks_.state_inputs());
}

void BatchRows::TryNext(std::size_t row, const float* action) {
  std::copy_n(action, networks_.actions(), next.row(row) + networks_.state_inputs());
}

std::vector<policy::HeadRun> BatchRows::Runs(std::size_t first, std::size_t count) const {
  return RunsOf(first, count, &Transition::head);
}

std::vector<policy::HeadRun> BatchRows::NextRuns(std::size_t first, std::size_t count) const {
  return RunsOf(first, count, &Transition::next_head);
}

std::vector<policy::HeadRun> BatchRows::RunsOf(std::size_t first, std::size_t count,
                                               std::int32_t Transition::*head) const {
  std::vector<policy::HeadRun> runs;
  for (std::size_t row = first; row < first + count; ++row) {
    policy::AddRow(of(row).*head, row, runs);
  }
  return runs;
}

}  // namespace metronome::sac
