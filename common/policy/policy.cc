#include "common/policy/policy.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "common/numbers/elementary.h"
#include "common/policy/gaussian.h"
#include "common/policy/network_input.h"
#include "common/policy/squashed_gaussian.h"

namespace metronome::policy {
namespace {

// @throws std::invalid_argument unless the snapshot has the shape.
const float* ParametersOf(const PolicySnapshot& snapshot, const NetworkShape& shape) {
  const std::size_t expected = ActorLayout(shape).size;
  if (snapshot.parameters.size() == expected &&
      snapshot.observation_mean.size() == shape.statistics() &&
      snapshot.observation_inv_std.size() == shape.statistics()) {
    return snapshot.parameters.data();
  }
  throw std::invalid_argument("policy snapshot " + std::to_string(snapshot.version) + " has " +
                              std::to_string(snapshot.parameters.size()) +
                              " parameters, the run's network needs " + std::to_string(expected));
}

}  // namespace

Policy::Policy(const RunConfig& config, const PolicySnapshot& snapshot)
    : version_(snapshot.version),
      shape_(ShapeOf(config)),
      clip_(static_cast<float>(config.policy().observation_clip())),
      observation_mean_(snapshot.observation_mean),
      observation_inv_std_(snapshot.observation_inv_std),
      network_(ActorLayout(shape_), ParametersOf(snapshot, shape_)),
      input_(kMostStates, std::size_t(shape_.input())),
      rows_(ActorLayout(shape_), kMostStates) {
  if (shape_.squashed) return;
  const float* log_std = snapshot.parameters.data() + ActorLayout(shape_).log_std;
  for (std::int32_t head = 0; head < shape_.heads; ++head, log_std += shape_.action) {
    auto& log_stds = log_std_.emplace_back();
    auto& stds = std_.emplace_back();
    auto& inv_stds = inv_std_.emplace_back();
    for (int i = 0; i < shape_.action; ++i) {
      log_stds[i] = log_std[i];
      stds[i] = numbers::Exp(log_std[i]);
      inv_stds[i] = 1 / stds[i];
    }
  }
}

void Policy::RequireFit(const HeadSchedule& schedule) const {
  if (schedule.heads() == shape_.heads) return;
  throw std::invalid_argument("a schedule of " + std::to_string(schedule.heads()) +
                              " heads for a policy of " + std::to_string(shape_.heads));
}

void Policy::Gaussians(const HeadSchedule& schedule, const float* observations, std::int32_t t,
                       std::span<Gaussian> gaussians) {
  RequireFit(schedule);
  const Normaliser normaliser{observation_mean_.data(), observation_inv_std_.data(), clip_};
  runs_.clear();
  for (std::size_t i = 0; i < gaussians.size(); ++i) {
    const std::int32_t step = t + std::int32_t(i);
    WriteInput(shape_, normaliser, observations + i * std::size_t(shape_.observation),
               schedule.task(), step, schedule.horizon(), input_.row(i));
    AddRow(schedule.HeadAt(step), i, runs_);
  }
  network_.Forward(input_, rows_, 0, gaussians.size(), runs_);
  for (std::size_t i = 0; i < gaussians.size(); ++i) {
    const float* output = rows_.output.row(i);
    std::copy_n(output, shape_.action, gaussians[i].mean.begin());
    if (!shape_.squashed) {
      gaussians[i].log_std = log_std_[std::size_t(schedule.HeadAt(t + std::int32_t(i)))];
      continue;
    }
    std::transform(output + shape_.action, output + 2 * shape_.action, gaussians[i].log_std.begin(),
                   SquashedLogStd);
  }
}

Policy::Action Policy::Mean(const HeadSchedule& schedule, const float* observation,
                            std::int32_t t) {
  Gaussian gaussian;
  Gaussians(schedule, observation, t, {&gaussian, 1});
  if (shape_.squashed) {
    std::transform(gaussian.mean.begin(), gaussian.mean.begin() + shape_.action,
                   gaussian.mean.begin(), Squash);
  }
  return gaussian.mean;
}

Policy::Decision Policy::Act(const HeadSchedule& schedule, const float* observation, std::int32_t t,
                             const Action& noise) {
  Gaussian gaussian;
  Gaussians(schedule, observation, t, {&gaussian, 1});
  return ActAround(schedule, gaussian, t, noise);
}

Policy::Decision Policy::ActAround(const HeadSchedule& schedule, const Gaussian& gaussian,
                                   std::int32_t t, const Action& noise) const {
  RequireFit(schedule);
  Decision decision;
  decision.mean = gaussian.mean;
  decision.head = schedule.HeadAt(t);
  if (shape_.squashed) {
    decision.log_prob = DrawSquashed(gaussian.mean.data(), gaussian.log_std.data(), noise.data(),
                                     shape_.action, decision.action.data());
    return decision;
  }
  const auto& stds = std_[decision.head];
  for (int i = 0; i < shape_.action; ++i) {
    decision.action[i] = decision.mean[i] + stds[i] * noise[i];
  }
  decision.log_prob =
      GaussianLogProb(decision.action.data(), decision.mean.data(), inv_std_[decision.head].data(),
                      log_std_[decision.head].data(), shape_.action);
  return decision;
}

Policy::Decision Policy::ActUniformly(const HeadSchedule& schedule, std::int32_t t,
                                      const Action& uniform) const {
  RequireFit(schedule);
  constexpr float kLogTwo = 0.693147180559945309F;
  Decision decision;
  decision.head = schedule.HeadAt(t);
  decision.action = uniform;
  decision.log_prob = -kLogTwo * float(shape_.action);
  return decision;
}

}  // namespace metronome::policy
