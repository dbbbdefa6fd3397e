#include "learner/sac/sac_report.h"

#include <algorithm>
#include <string>

#include "common/numbers/elementary.h"

namespace metronome::sac {

SacReport EmptySacReport(std::size_t heads) {
  SacReport report;
  for (auto* list :
       {&report.head_samples, &report.head_entropy, &report.head_value, &report.head_temperature}) {
    list->resize(heads);
  }
  return report;
}

void Finish(const std::vector<float>& log_temperature, std::size_t replay_steps,
            SacReport& report) {
  report.replay_steps = replay_steps;
  const double steps = std::max<double>(1, double(report.gradient_steps));
  for (double* sum : {&report.critic_loss, &report.actor_loss, &report.critic_gradient_norm,
                      &report.actor_gradient_norm}) {
    *sum /= steps;
  }
  for (std::size_t head = 0; head < log_temperature.size(); ++head) {
    const double samples = std::max(1.0, report.head_samples[head]);
    report.head_entropy[head] /= samples;
    report.head_value[head] /= samples;
    report.head_temperature[head] = numbers::Exp(double{log_temperature[head]});
  }
}

std::vector<algorithm::Metric> SacMetrics(const SacReport& report) {
  std::vector<algorithm::Metric> metrics = {
      {"critic_loss", "loss/critic", report.critic_loss,
       "mean over the update's gradient steps, as the next three: cross-entropy of the targets by "
       "the critics, nats"},
      {"actor_loss", "loss/actor", report.actor_loss,
       "temperature times log-density, less the value in symlog"},
      {"critic_gradient_norm", "sac/critic_gradient_norm", report.critic_gradient_norm,
       "of both critics, before clipping"},
      {"actor_gradient_norm", "sac/actor_gradient_norm", report.actor_gradient_norm,
       "before clipping"},
      {"gradient_steps", "sac/gradient_steps", report.gradient_steps, "made by this update"},
      {"replay_steps", "sac/replay_steps", report.replay_steps,
       "of the environment, that the replay holds"},
  };
  for (std::size_t head = 0; head < report.head_entropy.size(); ++head) {
    const std::string number = std::to_string(head);
    metrics.push_back({"entropy_head" + number, "head/entropy/" + number, report.head_entropy[head],
                       "entropy of the head over its samples, nats"});
    metrics.push_back({"value_head" + number, "head/value/" + number, report.head_value[head],
                       "value of the head's actions over its samples, in symlog"});
    metrics.push_back({"temperature_head" + number, "head/temperature/" + number,
                       report.head_temperature[head], "of the head, after the update"});
  }
  return metrics;
}

}  // namespace metronome::sac
