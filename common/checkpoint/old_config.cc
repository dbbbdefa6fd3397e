#include "common/checkpoint/old_config.h"

#include "common/schema/checkpoint.pb.h"

namespace metronome::checkpoint {
namespace {

// ppo.success_reward said both.
void CompleteReward(RunConfig& config) {
  EnvironmentConfig& environment = *config.mutable_environment();
  if (environment.has_reward()) return;
  environment.set_reward(REWARD_OFFICIAL);
  if (!config.has_ppo()) return;
  ConfigOfFormat7 old;
  old.ParseFromString(config.SerializeAsString());
  config.mutable_ppo()->DiscardUnknownFields();
  if (old.ppo().success_reward() == 0) return;
  environment.set_reward(REWARD_SUCCESS);
  environment.set_success_reward(old.ppo().success_reward());
}

}  // namespace

void CompleteOldConfig(RunConfig& config) {
  PolicyConfig& policy = *config.mutable_policy();
  if (!policy.has_noise_correlation()) policy.set_noise_correlation(0);
  if (!policy.has_critic_time()) policy.set_critic_time(false);
  CompleteReward(config);
  if (!config.has_ppo()) return;
  PpoConfig& ppo = *config.mutable_ppo();
  if (!ppo.has_shared_heads()) ppo.set_shared_heads(false);
  if (!ppo.has_min_std()) ppo.set_min_std(0);
  if (!ppo.has_std_decay()) ppo.set_std_decay(0);
  if (!ppo.has_log_std_rate()) ppo.set_log_std_rate(1);
  if (!ppo.has_reward_scale_decay()) ppo.set_reward_scale_decay(1);
  if (!ppo.has_success_weight()) ppo.set_success_weight(0);
  if (!ppo.has_earlier_batches()) ppo.set_earlier_batches(0);
}

}  // namespace metronome::checkpoint
