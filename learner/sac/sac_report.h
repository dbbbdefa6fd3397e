#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "learner/algorithm/metric.h"
#include "learner/algorithm/update_report.h"

namespace metronome::sac {

/// The figures of one update of SAC. Losses and norms are means over its gradient steps, 0 without.
struct SacReport : algorithm::UpdateReport {
  double critic_loss = 0;  // cross-entropy, nats, mean of both critics
  double actor_loss = 0;   // temperature * log-density - value, in symlog
  double critic_gradient_norm = 0;
  double actor_gradient_norm = 0;
  std::uint64_t gradient_steps = 0;
  std::uint64_t replay_steps = 0;  // of the environment, that are kept
  // Per head, [heads]: over its samples in all gradient steps; 0 without.
  std::vector<double> head_samples;
  std::vector<double> head_entropy;      // nats, of the actions tried
  std::vector<double> head_value;        // of these, the lesser critic's, in symlog
  std::vector<double> head_temperature;  // after the update
};

SacReport EmptySacReport(std::size_t heads);

/// Makes means of the sums.
void Finish(const std::vector<float>& log_temperature, std::size_t replay_steps, SacReport& report);

/// SAC's own metrics, in the order of progress.csv's columns: of all samples, then those per head.
std::vector<algorithm::Metric> SacMetrics(const SacReport& report);

}  // namespace metronome::sac
