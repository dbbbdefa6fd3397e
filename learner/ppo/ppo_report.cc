#include "learner/ppo/ppo_report.h"

#include <stdexcept>
#include <string>

namespace metronome::ppo {
namespace {

void AddHeads(const std::string& name, const std::string& meaning,
              const std::vector<double>& values, std::size_t heads,
              std::vector<algorithm::Metric>& metrics) {
  if (values.size() != heads) throw std::invalid_argument(name + ": not one value a head");
  for (std::size_t head = 0; head < heads; ++head) {
    const std::string number = std::to_string(head);
    metrics.push_back({std::string(name).append("_head").append(number),
                       std::string("head/").append(name).append("/").append(number), values[head],
                       meaning});
  }
}

}  // namespace

PpoReport EmptyPpoReport(std::size_t heads) {
  PpoReport report;
  for (auto* list :
       {&report.head_entropy, &report.head_kl, &report.head_clip_share, &report.head_std}) {
    list->resize(heads);
  }
  return report;
}

std::vector<algorithm::Metric> PpoMetrics(const PpoReport& report) {
  std::vector<algorithm::Metric> metrics = {
      {"policy_loss", "loss/policy", report.policy_loss,
       "mean over all minibatches of all epochs made, each under the weights before its step"},
      {"value_loss", "loss/value", report.value_loss,
       "the same of half the squared error of scaled returns"},
      {"entropy", "loss/entropy", report.entropy, "the same of the policy's entropy, nats"},
      {"kl", "ppo/kl", report.kl,
       "mean of old minus new log-probability over the last minibatch (with `kl_estimate: "
       "KL_ESTIMATE_EPOCH` over the last epoch); old: at the start of the update"},
      {"clip_share", "ppo/clip_share", report.clip_share,
       "share of samples whose ratio was outside the clip range, over all minibatches"},
      {"explained_variance", "ppo/explained_variance", report.explained_variance,
       "of the returns by the values before the update, official ones where success has a value of "
       "its own"},
      {"gradient_norm", "ppo/gradient_norm", report.gradient_norm,
       "before clipping, mean over all minibatches"},
      {"learning_rate", "ppo/learning_rate", report.learning_rate, "as used by this update"},
      {"reward_scale", "ppo/reward_scale", report.reward_scale,
       "what this update divided rewards by, official ones where success has a value of its own"},
      {"epochs", "ppo/epochs", static_cast<std::uint64_t>(report.epochs),
       "made by this update, before the KL stop"},
      {"lag", "ppo/lag", report.lag,
       "updates between the weights that played and those that learnt"},
  };
  const std::size_t heads = report.head_entropy.size();
  AddHeads("entropy", "entropy of the head by the weights after the update, nats",
           report.head_entropy, heads, metrics);
  AddHeads("kl",
           "of the head's samples in all minibatches of all epochs (so not what `kl` is, which "
           "looks at the last); 0 if it had none",
           report.head_kl, heads, metrics);
  AddHeads("clip_share", "of the head's samples in all minibatches of all epochs; 0 if it had none",
           report.head_clip_share, heads, metrics);
  AddHeads("std", "mean standard deviation of the head by the weights after the update",
           report.head_std, heads, metrics);
  return metrics;
}

}  // namespace metronome::ppo
