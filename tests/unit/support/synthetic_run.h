#pragma once

#include <cstdint>
#include <vector>

#include "common/messages/episode.h"
#include "common/messages/messages.h"
#include "common/numbers/random.h"
#include "common/policy/explorer.h"
#include "common/policy/head_schedule.h"
#include "common/policy/policy.h"
#include "common/schema/config.pb.h"
#include "tests/unit/support/environments.h"

/// A run without physics: small networks, and episodes whose observations are noise, whose actions
/// are the policy's own and whose reward prefers small actions. Pure functions of their arguments.
namespace metronome::testing {

inline RunConfig SmallConfig(Method method = MULTIHEAD, int heads = 3, int overlap = 0) {
  RunConfig config;
  config.set_seed(5);
  config.set_total_steps(4000);
  test::SetTask(config, "push");
  config.mutable_environment()->set_horizon(40);
  config.mutable_policy()->set_method(method);
  config.mutable_policy()->set_heads(method == MULTIHEAD ? heads : 1);
  config.mutable_policy()->add_hidden(13);  // no multiple of a vector's width
  config.mutable_policy()->add_hidden(9);
  // Heads by themselves and nothing that bends the gradient: tests of more set it.
  config.mutable_environment()->set_reward(REWARD_OFFICIAL);
  config.mutable_policy()->set_critic_time(false);
  config.mutable_policy()->set_initial_log_std(-0.5);
  config.mutable_policy()->set_noise_correlation(0);
  config.mutable_ppo()->set_shared_heads(false);
  config.mutable_ppo()->set_entropy_coefficient(0.005);
  config.mutable_ppo()->set_min_std(0);
  config.mutable_ppo()->set_std_decay(0);
  config.mutable_ppo()->set_log_std_rate(1);
  config.mutable_ppo()->set_reward_scale_decay(1);
  config.mutable_ppo()->set_success_weight(0);
  config.mutable_ppo()->set_earlier_batches(0);
  config.mutable_ppo()->set_learning_rate(5e-4);
  config.mutable_ppo()->set_epochs(3);
  config.mutable_ppo()->set_minibatch(150);  // and a smaller last one
  config.mutable_ppo()->set_kl_stop(0);
  config.mutable_collection()->set_episodes_per_update(10);
  config.mutable_collection()->set_overlap(overlap);
  return config;
}

/// The same by SAC: small networks, a small batch, two gradient steps an update.
inline RunConfig SmallSacConfig(Method method = MULTIHEAD, int heads = 3, int overlap = 0) {
  RunConfig config = SmallConfig(method, heads, overlap);
  config.clear_ppo();
  SacConfig& sac = *config.mutable_sac();
  sac.set_batch(60);
  sac.set_replay_ratio(0.3);  // of 400 steps an update
  sac.set_replay_steps(1000);
  sac.set_random_episodes(10);
  sac.add_critic_hidden(11);
  sac.add_critic_hidden(7);
  sac.set_bins(21);
  sac.set_actor_learning_rate(1e-3);
  sac.set_critic_learning_rate(1e-3);
  sac.set_temperature_learning_rate(3e-4);
  return config;
}

inline Episode SyntheticEpisode(const RunConfig& config, const PolicySnapshot& snapshot,
                                std::uint64_t number) {
  policy::Policy policy(config, snapshot);
  const auto schedule = policy::HeadSchedule::OfTraining(config, number);
  policy::Explorer explorer(config, number);
  Episode episode;
  episode.number = number;
  episode.weights_version = snapshot.version;
  const std::int32_t horizon = config.environment().horizon();
  numbers::RandomStream random(numbers::RandomPurpose::kEvaluate, 99, number, 0);
  for (std::int32_t t = 0; t <= horizon; ++t) {
    for (int i = 0; i < test::kObservationSize; ++i) {
      // Dimensions 11..17 are constant zeros, as in Meta-World.
      const bool constant = i >= 11 && i < 18;
      episode.observation.push_back(constant ? 0.0F : 0.3F * float(i) + float(random.Normal()));
    }
    if (t == horizon) break;
    const float* row = episode.observation.data() + std::size_t(t) * test::kObservationSize;
    const policy::Policy::Decision decision = explorer.Act(policy, schedule, row, t);
    float cost = 0;
    for (int i = 0; i < test::kActionSize; ++i) {
      const float action = decision.action[i];
      episode.action.push_back(action);
      cost += action * action;
    }
    episode.log_prob.push_back(decision.log_prob);
    episode.head.push_back(std::uint16_t(decision.head));
    episode.reward.push_back(1 / (1 + cost) + 0.1F * float(random.Normal()));
    episode.flags.push_back(t + 1 == horizon ? kStepTruncated : 0);
  }
  if (number % 3 == 0) episode.flags[5] |= kStepSuccess;
  return episode;
}

inline std::vector<Episode> SyntheticBatch(const RunConfig& config, const PolicySnapshot& snapshot,
                                           std::uint64_t batch) {
  const auto count = std::uint64_t(config.collection().episodes_per_update());
  std::vector<Episode> episodes;
  for (std::uint64_t i = 0; i < count; ++i) {
    episodes.push_back(SyntheticEpisode(config, snapshot, batch * count + i));
  }
  return episodes;
}

}  // namespace metronome::testing
