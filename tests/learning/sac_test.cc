#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <iostream>
#include <vector>

#include "actor/play/evaluate.h"
#include "actor/play/rollout.h"
#include "common/config/config.h"
#include "common/policy/head_schedule.h"
#include "learner/sac/sac_state.h"
#include "learner/sac/trainer.h"
#include "tests/learning/orders.h"

namespace metronome::sac {
namespace {

using test::BestReturn;
using test::OrderRules;

/// A head for each step, which knows the time by being that head alone; one step is bootstrapped
/// from the next head's value. First come enough random actions to tell what follows from what.
RunConfig ConfigOf(const environment::EnvironmentRegistry& registry) {
  RunConfig config;
  config.set_seed(2);
  EnvironmentConfig& environment = *config.mutable_environment();
  environment.set_task("orders");
  *environment.mutable_spec() = registry.Describe("orders");
  environment.set_reward(REWARD_OFFICIAL);
  PolicyConfig& policy = *config.mutable_policy();
  policy.set_heads(environment.spec().max_steps());
  policy.set_critic_time(false);
  policy.add_hidden(24);
  config.mutable_collection()->set_episodes_per_update(64);
  config.mutable_collection()->set_overlap(0);
  SacConfig& sac = *config.mutable_sac();
  sac.add_critic_hidden(32);
  sac.set_batch(64);
  sac.set_replay_ratio(16);
  sac.set_random_episodes(512);
  sac.set_n_step(1);
  sac.set_actor_learning_rate(1e-3);
  sac.set_critic_learning_rate(5e-3);
  sac.set_initial_temperature(0.01);
  sac.set_temperature_learning_rate(1e-2);
  sac.set_target_rate(0.05);
  sac.set_target_std(0.1);
  sac.set_target_std_decay(0);
  sac.set_learning_rate_floor(1);
  sac.set_noise_spread(1);
  sac.set_shared_heads(false);
  return config;
}

std::vector<Episode> Play(const RunConfig& config, const SacState& state,
                          environment::Environment& environment) {
  const PolicySnapshot snapshot = SnapshotOf(state, config);
  const std::atomic<bool> cancel = false;
  std::vector<Episode> batch;
  for (int i = 0; i < config.collection().episodes_per_update(); ++i) {
    const std::uint64_t number = state.episodes_used + std::uint64_t(i);
    batch.push_back(play::PlayEpisode(config, snapshot, number, environment, cancel).value());
  }
  return batch;
}

/// @return the return of the policy without noise after 25 updates: a pure function of the seed.
double LearntReturn(const RunConfig& config, environment::Environment& environment) {
  Trainer trainer(config, InitialSacState(config), {}, 1);
  for (int i = 0; i < 25; ++i) trainer.Update(Play(config, trainer.state(), environment));
  return play::PlayDeterministic(config, SnapshotOf(trainer.state(), config),
                                 policy::HeadSchedule::OfTraining(config, 0),
                                 environment::TrainingStart(config, 0), environment)
      .episode_return;
}

/// What is learnt of the game of `rules` under a few other settings.
double Learn(const OrderRules& rules, const SacConfig& settings) {
  const environment::EnvironmentRegistry registry({test::Orders(rules)});
  RunConfig config = ConfigOf(registry);
  config.mutable_sac()->MergeFrom(settings);
  config = config::Resolve(config);
  config::Validate(config);
  return LearntReturn(config, *registry.Make(config.environment()));
}

/// More is as wrong as less: the best orders are so under a discount, returns are not discounted.
void ExpectAbout(double learnt, double best, double most = 1.1) {
  std::cout << "learnt " << learnt << ", best " << best << '\n';
  EXPECT_GT(learnt, 0.75 * best);
  EXPECT_LT(learnt, most * best);
}

TEST(SacLearningTest, EachHeadDoesWhatItsOwnTimeAsksFor) {
  OrderRules rules;
  rules.worth = {0, 1, -1, 1, 1, -1, -1, 1};
  SacConfig settings;
  settings.set_discount(0.8);
  ExpectAbout(Learn(rules, settings), BestReturn(rules, 0.8));
}

TEST(SacLearningTest, WhatComesSomeHeadsLaterIsWorthItsDiscountedValue) {
  OrderRules rules;
  rules.worth = {0, 0, 1, -1, 1};
  rules.delay = 2;
  SacConfig settings;
  settings.set_discount(0.7);
  const double best = BestReturn(rules, 0.7);
  ExpectAbout(Learn(rules, settings), best);
  settings.set_n_step(2);
  ExpectAbout(Learn(rules, settings), best);
  // What arrives is then among the rewards before the value: taken by earlier policies.
  settings.set_n_step(3);
  ExpectAbout(Learn(rules, settings), best, 1.25);
}

TEST(SacLearningTest, NothingIsWorthAnythingAfterTheEnd) {
  OrderRules rules;
  rules.worth = {1, 1, 1, 1};
  SacConfig settings;
  settings.set_discount(0.9);
  const double best = BestReturn(rules, 0.9);
  ExpectAbout(Learn(rules, settings), best);  // the time limit counts as the end
  settings.set_time_limit_value(BOOTSTRAP);
  rules.terminates = true;
  ExpectAbout(Learn(rules, settings), best);
}

// The last head orders too, in vain: by its own value of the state after the last step.
TEST(SacLearningTest, TheStateAtTheTimeLimitIsWorthWhatTheLastHeadSaysIfThatIsAskedFor) {
  OrderRules rules;
  rules.worth = {1, 1, 1, 1};
  SacConfig settings;
  settings.set_discount(0.9);
  settings.set_time_limit_value(BOOTSTRAP);
  ExpectAbout(Learn(rules, settings), BestReturn(rules, 0.9) - 0.9 * 0.9 / 2);
}

}  // namespace
}  // namespace metronome::sac
