#include "learner/sac/schedules.h"

#include <algorithm>

#include "common/numbers/elementary.h"

namespace metronome::sac {
namespace {

// Of the whole run.
double GradientSteps(const RunConfig& config) {
  return double(GradientStepsDue(std::uint64_t(config.total_steps()), config));
}

}  // namespace

std::uint64_t GradientStepsDue(std::uint64_t steps, const RunConfig& config) {
  const auto random =
      std::uint64_t(config.sac().random_episodes()) * std::uint64_t(config.environment().horizon());
  if (steps <= random) return 0;
  return std::uint64_t(config.sac().replay_ratio() * double(steps - random) /
                       double(config.sac().batch()));
}

double LearningRateShare(std::uint64_t gradient_step, const RunConfig& config) {
  return std::max(config.sac().learning_rate_floor(),
                  1 - double(gradient_step) / GradientSteps(config));
}

double TargetLogStd(std::uint64_t gradient_step, const RunConfig& config) {
  const SacConfig& sac = config.sac();
  const double first = numbers::Log(sac.target_std());
  const double falling = sac.target_std_decay() * GradientSteps(config);
  if (falling == 0) return first;
  const double last = numbers::Log(sac.final_target_std());
  return first + (last - first) * std::min(1.0, double(gradient_step) / falling);
}

}  // namespace metronome::sac
