#include "learner/record/metrics.h"

#include <fmt/format.h>

#include <stdexcept>

#include "learner/record/rates.h"

namespace metronome {
namespace {

void AddTraining(const UpdateReport& report, std::vector<Metric>& metrics) {
  metrics.insert(metrics.end(),
                 {{"steps", "train/steps", report.steps},
                  {"update", "train/update", report.version},
                  {"episodes", "train/episodes", report.episodes},
                  {"return", "train/return", report.mean_return},
                  {"success", "train/success", report.success},
                  {"success_end", "train/success_end", report.success_end},
                  {"policy_loss", "loss/policy", report.policy_loss},
                  {"value_loss", "loss/value", report.value_loss},
                  {"entropy", "loss/entropy", report.entropy},
                  {"kl", "ppo/kl", report.kl},
                  {"clip_share", "ppo/clip_share", report.clip_share},
                  {"explained_variance", "ppo/explained_variance", report.explained_variance},
                  {"gradient_norm", "ppo/gradient_norm", report.gradient_norm},
                  {"learning_rate", "ppo/learning_rate", report.learning_rate},
                  {"reward_scale", "ppo/reward_scale", report.reward_scale},
                  {"epochs", "ppo/epochs", static_cast<std::uint64_t>(report.epochs)},
                  {"lag", "ppo/lag", report.lag}});
}

void AddHeads(const std::string& name, const std::vector<double>& values, std::size_t heads,
              std::vector<Metric>& metrics) {
  if (values.size() != heads) throw std::invalid_argument(name + ": not one value a head");
  for (std::size_t head = 0; head < heads; ++head) {
    metrics.push_back({fmt::format("{}_head{}", name, head), fmt::format("head/{}/{}", name, head),
                       values[head]});
  }
}

void AddWall(const UpdateReport& report, const WallReport& wall, std::vector<Metric>& metrics) {
  const double fps = StepsPerSecond(report.steps, wall.seconds);
  metrics.push_back({"fps", "wall/fps", fps});
  metrics.push_back({"wall_seconds", "wall/seconds", wall.seconds});
  metrics.push_back({"wall_collect_seconds", "wall/collect_seconds", wall.collect_seconds});
  metrics.push_back({"wall_update_seconds", "wall/update_seconds", wall.update_seconds});
  metrics.push_back({"wall_idle_share", "wall/idle_share", wall.idle_share});
  metrics.push_back({"wall_bytes_sent", "wall/bytes_sent", wall.bytes_sent});
  metrics.push_back({"wall_bytes_received", "wall/bytes_received", wall.bytes_received});
  metrics.push_back({"wall_actors", "wall/actors", wall.actors});
  metrics.push_back({"wall_slots", "wall/slots", wall.slots});
  metrics.push_back({"wall_orders_repeated", "wall/orders_repeated", wall.orders_repeated});
}

}  // namespace

std::vector<Metric> MetricsOf(const UpdateReport& report, const WallReport& wall) {
  std::vector<Metric> metrics;
  AddTraining(report, metrics);
  const std::size_t heads = report.head_entropy.size();
  AddHeads("entropy", report.head_entropy, heads, metrics);
  AddHeads("kl", report.head_kl, heads, metrics);
  AddHeads("clip_share", report.head_clip_share, heads, metrics);
  AddHeads("std", report.head_std, heads, metrics);
  AddWall(report, wall, metrics);
  return metrics;
}

}  // namespace metronome
