#pragma once

#include <cstdint>
#include <vector>

#include "learner/algorithm/metric.h"
#include "learner/algorithm/update_report.h"

namespace metronome::ppo {

/// The figures of one update of PPO.
struct PpoReport : algorithm::UpdateReport {
  // Means over all minibatches of all epochs made, each under the weights before its step.
  double policy_loss = 0;
  double value_loss = 0;          // half squared error, of scaled returns
  double entropy = 0;             // nats
  double kl = 0;                  // mean old minus new log-probability, by ppo.kl_estimate
  double clip_share = 0;          // samples whose ratio left [1 - clip, 1 + clip], all minibatches
  double explained_variance = 0;  // of the returns by the values before the update
  double gradient_norm = 0;       // before clipping, mean over all minibatches
  double learning_rate = 0;
  double reward_scale = 0;  // what rewards were divided by, mean over tasks
  std::int32_t epochs = 0;  // made before the KL stop
  std::uint64_t lag = 0;    // updates between the behaviour's weights and those trained
  // Per head, [k]. By the weights after the update:
  std::vector<double> head_entropy;  // nats
  std::vector<double> head_std;      // mean of exp(log_std)
  // Over the head's samples in all minibatches of all epochs (`kl` may be of the last one); 0
  // without.
  std::vector<double> head_kl;
  std::vector<double> head_clip_share;
};

/// Of a policy with `heads` heads in all, before any update.
PpoReport EmptyPpoReport(std::size_t heads);

/// PPO's own metrics, in the order of progress.csv's columns: of all samples, then those per head.
/// @throws std::invalid_argument if the per-head lists differ in length.
std::vector<algorithm::Metric> PpoMetrics(const PpoReport& report);

}  // namespace metronome::ppo
