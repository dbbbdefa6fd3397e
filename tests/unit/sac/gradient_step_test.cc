#include "learner/sac/gradient_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "common/numbers/random.h"
#include "learner/sac/draw_batch.h"
#include "learner/sac/replay.h"
#include "learner/sac/sac_networks.h"
#include "learner/sac/sac_state.h"
#include "tests/unit/support/double_network.h"
#include "tests/unit/support/synthetic_run.h"

namespace metronome::sac {
namespace {

using testing::Forward;
using testing::SmallSacConfig;
using testing::SyntheticEpisode;

using Doubles = std::vector<double>;

Doubles Of(const std::vector<float>& floats) { return {floats.begin(), floats.end()}; }

double Symlog(double x) { return std::copysign(std::log1p(std::abs(x)), x); }
double Symexp(double x) { return std::copysign(std::expm1(std::abs(x)), x); }

/// The two losses of a gradient step in double, written from their definitions: cross-entropy of
/// two-hot targets in symlog, and temperature * log-density - lesser value, of a squashed Gaussian.
class Losses {
 public:
  Losses(const RunConfig& config, const std::vector<Transition>& batch,
         const PolicySnapshot& normaliser, std::uint64_t gradient_step)
      : config_(config),
        networks_(config),
        batch_(batch),
        normaliser_(normaliser),
        gradient_step_(gradient_step) {}

  /// Mean over the batch of both critics' cross-entropies, added.
  [[nodiscard]] double OfCritics(const Doubles& critics, const Doubles& targets,
                                 const Doubles& actor) const {
    double loss = 0;
    for (std::size_t row = 0; row < batch_.size(); ++row) {
      const Transition& transition = batch_[row];
      const ReplayEpisode& of = *transition.step.of;
      double target = transition.reward;
      if (transition.next_discount > 0) {
        const Doubles state = State(of, transition.next_t);
        const Doubles action = Try(actor, state, transition.next_head, 2 * row).action;
        target += transition.next_discount *
                  Symexp(Least(targets, transition.next_t, transition.next_head, state, action));
      }
      const auto at = of.episode.action.begin() + std::ptrdiff_t(4 * transition.step.t);
      const Doubles action(at, at + 4);
      const Doubles state = State(of, transition.step.t);
      for (std::size_t i = 0; i < kCritics; ++i) {
        const Doubles p =
            Distribution(critics, i, transition.step.t, transition.head, state, action);
        loss -= TwoHotLog(p, Symlog(target));
      }
    }
    return loss / double(batch_.size());
  }

  [[nodiscard]] double OfActor(const Doubles& actor, const Doubles& critics,
                               const Doubles& log_temperature) const {
    double loss = 0;
    for (std::size_t row = 0; row < batch_.size(); ++row) {
      const Transition& transition = batch_[row];
      const Doubles state = State(*transition.step.of, transition.step.t);
      const Tried tried = Try(actor, state, transition.head, 2 * row + 1);
      loss += std::exp(log_temperature[std::size_t(transition.head)]) * tried.log_prob -
              Least(critics, transition.step.t, transition.head, state, tried.action);
    }
    return loss / double(batch_.size());
  }

 private:
  struct Tried {
    Doubles action;
    double log_prob = 0;
  };

  [[nodiscard]] Doubles State(const ReplayEpisode& of, std::int32_t t) const {
    Doubles state;
    for (std::size_t i = 0; i < 39; ++i) {
      const double x = of.episode.observation[std::size_t(t) * 39 + i];
      state.push_back(std::clamp(
          (x - normaliser_.observation_mean[i]) * normaliser_.observation_inv_std[i], -10.0, 10.0));
    }
    if (networks_.shape.time_feature) state.push_back(2.0 * t / 40 - 1);
    return state;
  }

  [[nodiscard]] Tried Try(const Doubles& actor, const Doubles& state, std::int32_t head,
                          std::uint64_t draw) const {
    const Doubles output = Forward(actor, networks_.actor, state, head);
    numbers::RandomStream random(numbers::RandomPurpose::kUpdateNoise, config_.seed(),
                                 gradient_step_, draw);
    Tried tried;
    for (std::size_t i = 0; i < 4; ++i) {
      const double noise = random.Normal();
      const double log_std = -5 + 3.5 * (std::tanh(output[4 + i]) + 1);
      const double u = output[i] + std::exp(log_std) * noise;
      tried.action.push_back(std::tanh(u));
      tried.log_prob += -0.5 * noise * noise - log_std - 0.5 * std::log(2 * M_PI) -
                        std::log(1 - std::pow(std::tanh(u), 2));
    }
    return tried;
  }

  [[nodiscard]] Doubles Distribution(const Doubles& critics, std::size_t which, std::int32_t t,
                                     std::int32_t head, const Doubles& state,
                                     const Doubles& action) const {
    const auto begin = critics.begin() + std::ptrdiff_t(which * networks_.critic.size);
    const Doubles critic(begin, begin + std::ptrdiff_t(networks_.critic.size));
    Doubles input = state;
    if (networks_.shape.critic_time) input.push_back(2.0 * t / 40 - 1);
    input.insert(input.end(), action.begin(), action.end());
    Doubles p = Forward(critic, networks_.critic, input, networks_.shape.value_head(head));
    double sum = 0;
    for (double& value : p) sum += value = std::exp(value);
    for (double& value : p) value /= sum;
    return p;
  }

  [[nodiscard]] double Bin(std::size_t i) const {
    return -10 + 20.0 * double(i) / double(networks_.bins - 1);
  }

  [[nodiscard]] double Least(const Doubles& critics, std::int32_t t, std::int32_t head,
                             const Doubles& state, const Doubles& action) const {
    double least = INFINITY;
    for (std::size_t which = 0; which < kCritics; ++which) {
      const Doubles p = Distribution(critics, which, t, head, state, action);
      double mean = 0;
      for (std::size_t i = 0; i < p.size(); ++i) mean += p[i] * Bin(i);
      least = std::min(least, mean);
    }
    return least;
  }

  [[nodiscard]] double TwoHotLog(const Doubles& p, double at) const {
    double sum = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const double width = Bin(1) - Bin(0);
      sum += std::max(0.0, 1 - std::abs(at - Bin(i)) / width) * std::log(p[i]);
    }
    return sum;
  }

  RunConfig config_;
  SacNetworks networks_;
  const std::vector<Transition>& batch_;
  const PolicySnapshot& normaliser_;
  std::uint64_t gradient_step_;
};

/// Method, critic's heads, whether the critic sees the time, whether it is normalised.
class SacGradientTest
    : public ::testing::TestWithParam<std::tuple<Method, CriticHeads, bool, bool>> {
 protected:
  SacGradientTest() {
    config_.mutable_policy()->set_critic_heads(std::get<1>(GetParam()));
    config_.mutable_policy()->set_critic_time(std::get<2>(GetParam()));
    config_.mutable_sac()->set_critic_norm(std::get<3>(GetParam()));
    // The policy's gradient is by critics that the same step has changed: by next to nothing here.
    config_.mutable_sac()->set_critic_learning_rate(1e-12);
    SacState state = InitialSacState(config_);
    for (std::uint64_t i = 0; i < 20; ++i) {
      replay_.Add(SyntheticEpisode(config_, SnapshotOf(state, config_), i));
    }
    normaliser_ = SnapshotOf(state, config_);
    state_ = state.optimiser;
    numbers::RandomStream random(numbers::RandomPurpose::kEvaluate, 8, 8, 8);
    for (auto* weights : {&state_.actor, &state_.critics, &state_.targets}) {
      for (float& weight : *weights) weight += 0.2F * float(random.Normal());
    }
    for (float& log : state_.log_temperature) log = float(0.3 * random.Normal());
    state_.gradient_steps = 7;
    batch_ = DrawBatch(replay_, config_, 7);
  }

  RunConfig config_ = SmallSacConfig(std::get<0>(GetParam()));
  Replay replay_{config_};
  PolicySnapshot normaliser_;
  OptimiserState state_;
  std::vector<Transition> batch_;
};

template <typename Loss>
void ExpectGradient(const std::vector<float>& gradient, Doubles at, const Loss& loss) {
  ASSERT_EQ(gradient.size(), at.size());
  for (std::size_t i = 0; i < at.size(); i += at.size() / 150 + 1) {
    const double here = at[i];
    const double h = 1e-5;
    at[i] = here + h;
    const double up = loss(at);
    at[i] = here - h;
    const double down = loss(at);
    at[i] = here;
    const double want = (up - down) / (2 * h);
    ASSERT_NEAR(gradient[i], want, 1e-5 + 1e-3 * std::abs(want)) << "parameter " << i;
  }
}

TEST_P(SacGradientTest, AgreesWithFiniteDifferencesOfIndependentLosses) {
  const OptimiserState before = state_;
  network::WorkerTeam team(2);
  GradientStep step(config_, team);
  step.Begin(state_);
  const StepFigures figures = step.Run(batch_, normaliser_, state_);
  const Losses losses(config_, batch_, normaliser_, 7);
  const Doubles actor = Of(before.actor);
  const Doubles critics = Of(before.critics);
  const Doubles targets = Of(before.targets);
  const Doubles temperature = Of(before.log_temperature);
  EXPECT_NEAR(figures.critic_loss, losses.OfCritics(critics, targets, actor) / 2, 1e-4);
  EXPECT_NEAR(figures.actor_loss, losses.OfActor(actor, critics, temperature), 1e-4);
  ExpectGradient(step.critic_gradient(), critics,
                 [&](const Doubles& at) { return losses.OfCritics(at, targets, actor); });
  ExpectGradient(step.actor_gradient(), actor,
                 [&](const Doubles& at) { return losses.OfActor(at, critics, temperature); });
}

INSTANTIATE_TEST_SUITE_P(Arms, SacGradientTest,
                         ::testing::Combine(::testing::Values(MULTIHEAD, SINGLE, SINGLE_TIME),
                                            ::testing::Values(CRITIC_HEADS_SEPARATE,
                                                              CRITIC_HEADS_SHARED),
                                            ::testing::Bool(), ::testing::Bool()));

// Adam's first step is the rate.
TEST(GradientStepTest, TemperaturesRiseWhereThePolicyHasTooLittleEntropy) {
  for (const double std : {1e-3, 1e2}) {
    RunConfig config = SmallSacConfig();
    config.mutable_sac()->set_target_std(std);
    SacState state = InitialSacState(config);
    Replay replay(config);
    const PolicySnapshot snapshot = SnapshotOf(state, config);
    for (std::uint64_t i = 0; i < 3; ++i) replay.Add(SyntheticEpisode(config, snapshot, i));
    network::WorkerTeam team(1);
    GradientStep step(config, team);
    step.Begin(state.optimiser);
    const std::vector<float> before = state.optimiser.log_temperature;
    step.Run(DrawBatch(replay, config, 0), snapshot, state.optimiser);
    for (std::size_t head = 0; head < before.size(); ++head) {
      const double moved = state.optimiser.log_temperature[head] - before[head];
      EXPECT_NEAR(moved, std > 1 ? 3e-4 : -3e-4, 1e-6);
    }
  }
}

TEST(GradientStepTest, TargetsFollowTheCriticsByTheirRate) {
  RunConfig config = SmallSacConfig();
  config.mutable_sac()->set_target_rate(0.25);
  SacState state = InitialSacState(config);
  for (float& weight : state.optimiser.targets) weight += 1;
  const std::vector<float> before = state.optimiser.targets;
  Replay replay(config);
  const PolicySnapshot snapshot = SnapshotOf(state, config);
  for (std::uint64_t i = 0; i < 3; ++i) replay.Add(SyntheticEpisode(config, snapshot, i));
  network::WorkerTeam team(2);
  GradientStep step(config, team);
  step.Begin(state.optimiser);
  step.Run(DrawBatch(replay, config, 0), snapshot, state.optimiser);
  for (std::size_t i = 0; i < before.size(); ++i) {
    ASSERT_FLOAT_EQ(state.optimiser.targets[i],
                    before[i] + 0.25F * (state.optimiser.critics[i] - before[i]));
  }
}

}  // namespace
}  // namespace metronome::sac
