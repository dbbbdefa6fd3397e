#include "learner/sac/gradient_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "common/kernels/matrix.h"
#include "common/messages/episode.h"
#include "common/numbers/elementary.h"
#include "common/numbers/random.h"
#include "common/policy/network_input.h"
#include "common/policy/squashed_gaussian.h"
#include "learner/algorithm/algorithm.h"
#include "learner/network/adam.h"
#include "learner/network/mlp.h"
#include "learner/sac/sac_networks.h"
#include "learner/sac/schedules.h"
#include "learner/sac/value_bins.h"

namespace metronome::sac {
namespace {

using kernels::Matrix;
using network::Mlp;
using policy::HeadRun;
using ActionArray = std::array<float, kMaxActionSize>;

constexpr std::size_t kRows = policy::PackedNetwork::kRows;

// What the policy does in one state, and what its gradient needs.
struct Tried {
  ActionArray action{};
  ActionArray noise{};
  ActionArray std{};
  float log_prob = 0;
  float value = 0;  // the lesser one, in symlog
};

// Of one sample, for the sums over all of them.
struct SampleFigures {
  std::array<float, kCritics> critic_loss{};
  Tried tried;
};

void RequireFinite(double norm, const char* what) {
  if (std::isfinite(norm)) return;
  throw algorithm::NonFiniteUpdate("the gradient of the " + std::string(what) +
                                   " is not finite (norm " + std::to_string(norm) + ")");
}

}  // namespace

struct GradientStep::Impl {
  Impl(const RunConfig& run_config, network::WorkerTeam& worker_team)
      : config(run_config),
        sac(run_config.sac()),
        networks(run_config),
        bins(networks.bins, float(sac.value_limit())),
        team(worker_team),
        samples(std::size_t(sac.batch())),
        actor(networks.actor, samples),
        critics{MakeCritic(), MakeCritic()},
        targets{MakeTarget(), MakeTarget()},
        actor_heads({networks.actor}),
        critic_heads({networks.critic, networks.critic}),
        state_input(samples, std::size_t(networks.shape.input())),
        next_state_input(samples, std::size_t(networks.shape.input())),
        critic_input(samples, networks.critic_inputs()),
        tried_input(samples, networks.critic_inputs()),
        next_input(samples, networks.critic_inputs()),
        probability{Matrix(samples, networks.bins), Matrix(samples, networks.bins)},
        figures(samples),
        actor_gradient(networks.actor.size),
        critic_gradient(kCritics * networks.critic.size) {}

  [[nodiscard]] Mlp MakeCritic() const { return {networks.critic, samples, networks.actions()}; }
  [[nodiscard]] Mlp MakeTarget() const { return {networks.critic, samples, 0, false}; }

  // ---- The batch.

  void Take(const std::vector<Transition>& of_batch, const PolicySnapshot& of_normaliser) {
    batch = &of_batch;
    normaliser = {of_normaliser.observation_mean.data(), of_normaliser.observation_inv_std.data(),
                  float(config.policy().observation_clip())};
    runs = RunsOf(0, samples, &Transition::head);
    value_runs = policy::ValueRuns(runs, networks.shape);
  }

  [[nodiscard]] std::vector<HeadRun> RunsOf(std::size_t first, std::size_t count,
                                            std::int32_t Transition::*head) const {
    std::vector<HeadRun> of_rows;
    for (std::size_t row = first; row < first + count; ++row) {
      policy::AddRow((*batch)[row].*head, row, of_rows);
    }
    return of_rows;
  }

  // What actor and critic see of the state after `t` steps.
  void WriteState(const ReplayEpisode& of, std::int32_t t, float* actor_row, float* critic_row) {
    const policy::NetworkShape& shape = networks.shape;
    const std::int32_t horizon = config.environment().horizon();
    policy::WriteInput(
        shape, normaliser,
        of.episode.observation.data() + std::size_t(t) * std::size_t(shape.observation), of.task, t,
        horizon, actor_row);
    std::copy_n(actor_row, shape.input(), critic_row);
    if (shape.critic_time) critic_row[shape.input()] = policy::Phase(t, horizon);
  }

  void Gather(std::size_t row) {
    const Transition& transition = (*batch)[row];
    const ReplayEpisode& of = *transition.step.of;
    WriteState(of, transition.step.t, state_input.row(row), critic_input.row(row));
    WriteState(of, transition.next_t, next_state_input.row(row), next_input.row(row));
    std::copy_n(critic_input.row(row), networks.state_inputs(), tried_input.row(row));
    const float* action =
        of.episode.action.data() + std::size_t(transition.step.t) * networks.actions();
    std::copy_n(action, networks.actions(), critic_input.row(row) + networks.state_inputs());
  }

  // ---- Rows of the batch: passes and losses.

  // The policy's action by its outputs of this row. @param which  0: of the next state, 1: of the
  // state.
  Tried Try(std::size_t row, std::uint64_t which) const {
    const float* output = actor.output().row(row);
    const std::size_t actions = networks.actions();
    numbers::RandomStream random(numbers::RandomPurpose::kUpdateNoise, config.seed(), gradient_step,
                                 2 * row + which);
    Tried tried;
    ActionArray log_std{};
    for (std::size_t i = 0; i < actions; ++i) {
      tried.noise[i] = float(random.Normal());
      log_std[i] = policy::SquashedLogStd(output[actions + i]);
      tried.std[i] = numbers::Exp(log_std[i]);
    }
    tried.log_prob = policy::DrawSquashed(output, log_std.data(), tried.noise.data(),
                                          std::int32_t(actions), tried.action.data());
    return tried;
  }

  // Turns the row's logits of one of two critics into probabilities. @return their mean, in symlog.
  float ValueOf(const Mlp& critic, std::size_t which, std::size_t row) {
    float* p = probability[which].row(row);
    std::copy_n(critic.output().row(row), networks.bins, p);
    Softmax(p, 1, networks.bins, probability[which].stride());
    return bins.Mean(p);
  }

  void CriticRows(std::size_t first, std::size_t count) {
    for (std::size_t row = first; row < first + count; ++row) Gather(row);
    const std::vector<HeadRun> next_runs = RunsOf(first, count, &Transition::next_head);
    actor.Forward(next_state_input, first, count, next_runs);
    for (std::size_t row = first; row < first + count; ++row) {
      std::copy_n(Try(row, 0).action.data(), networks.actions(),
                  next_input.row(row) + networks.state_inputs());
    }
    const std::vector<HeadRun> next_values = policy::ValueRuns(next_runs, networks.shape);
    for (Mlp& target : targets) target.Forward(next_input, first, count, next_values);
    const std::vector<HeadRun> values =
        policy::ValueRuns(RunsOf(first, count, &Transition::head), networks.shape);
    for (Mlp& critic : critics) critic.Forward(critic_input, first, count, values);
    for (std::size_t row = first; row < first + count; ++row) CriticLosses(row);
    for (Mlp& critic : critics) critic.Backward(first, count, values);
  }

  [[nodiscard]] float Target(std::size_t row) {
    const Transition& transition = (*batch)[row];
    if (transition.next_discount == 0) return transition.reward;
    const float next = std::min(ValueOf(targets[0], 0, row), ValueOf(targets[1], 1, row));
    return transition.reward + transition.next_discount * ValueBins::Symexp(next);
  }

  // Cross-entropy of the target's two bins by the critic's distribution.
  void CriticLosses(std::size_t row) {
    const ValueBins::TwoHot target = bins.Share(ValueBins::Symlog(Target(row)));
    for (std::size_t i = 0; i < kCritics; ++i) {
      ValueOf(critics[i], i, row);
      const float* p = probability[i].row(row);
      float* d = critics[i].d_output().row(row);
      for (std::size_t bin = 0; bin < networks.bins; ++bin) d[bin] = p[bin] * inv_samples();
      d[target.low] -= target.of_low * inv_samples();
      d[target.low + 1] -= target.of_high * inv_samples();
      figures[row].critic_loss[i] =
          float(-target.of_low * numbers::Log(double{p[target.low]} + 1e-30) -
                target.of_high * numbers::Log(double{p[target.low + 1]} + 1e-30));
    }
  }

  void ActorRows(std::size_t first, std::size_t count) {
    const std::vector<HeadRun> of_rows = RunsOf(first, count, &Transition::head);
    const std::vector<HeadRun> values = policy::ValueRuns(of_rows, networks.shape);
    actor.Forward(state_input, first, count, of_rows);
    for (std::size_t row = first; row < first + count; ++row) {
      figures[row].tried = Try(row, 1);
      std::copy_n(figures[row].tried.action.data(), networks.actions(),
                  tried_input.row(row) + networks.state_inputs());
    }
    for (Mlp& critic : critics) critic.Forward(tried_input, first, count, values);
    for (std::size_t row = first; row < first + count; ++row) ValueGradient(row);
    for (Mlp& critic : critics) critic.Backward(first, count, values);
    for (std::size_t row = first; row < first + count; ++row) ActorGradientOfOutputs(row);
    actor.Backward(first, count, of_rows);
  }

  // Of minus the lesser critic's value, by its logits: dv/dz_i = p_i (b_i - v).
  void ValueGradient(std::size_t row) {
    const float first = ValueOf(critics[0], 0, row);
    const float second = ValueOf(critics[1], 1, row);
    const std::size_t lesser = first < second ? 0 : 1;
    const float value = std::min(first, second);
    const float* p = probability[lesser].row(row);
    float* d = critics[lesser].d_output().row(row);
    for (std::size_t bin = 0; bin < networks.bins; ++bin) {
      d[bin] = -p[bin] * (bins.bins()[bin] - value) * inv_samples();
    }
    std::fill_n(critics[1 - lesser].d_output().row(row), networks.bins, 0.0F);
    figures[row].tried.value = value;
  }

  // Of temperature * log-density - value, by mean and log-std of the squashed Gaussian: u = mean +
  // std * noise, action = tanh(u); the log-density falls by ln(1 - action^2).
  void ActorGradientOfOutputs(std::size_t row) {
    const Tried& tried = figures[row].tried;
    const std::size_t actions = networks.actions();
    const float weight = temperature[std::size_t((*batch)[row].head)] * inv_samples();
    const float* output = actor.output().row(row);
    float* d = actor.d_output().row(row);
    for (std::size_t i = 0; i < actions; ++i) {
      const float a = tried.action[i];
      const float d_action = critics[0].d_input().row(row)[i] + critics[1].d_input().row(row)[i];
      const float d_u = weight * 2 * a + d_action * (1 - a * a);
      const float d_log_std = d_u * tried.std[i] * tried.noise[i] - weight;
      const float slope = policy::Squash(output[actions + i]);
      d[i] = d_u;
      d[actions + i] =
          d_log_std * 0.5F * (policy::kMostLogStd - policy::kLeastLogStd) * (1 - slope * slope);
    }
  }

  [[nodiscard]] float inv_samples() const { return 1.0F / float(samples); }

  // About kRows rows a task, equally many tasks for each thread.
  template <typename Task>
  void ForRows(const Task& task) {
    const std::size_t rounds = (samples + kRows * team.threads() - 1) / (kRows * team.threads());
    const std::size_t tasks = rounds * team.threads();
    team.Run(tasks, [&](std::size_t i) {
      const std::size_t first = i * samples / tasks;
      const std::size_t end = (i + 1) * samples / tasks;
      if (end > first) task(first, end - first);
    });
  }

  // ---- Parts of the parameters: gradients and steps.

  // @return the norm of both critics' gradients together.
  double CriticGradient() {
    const std::size_t parts = critics[0].gradient_parts();
    std::vector<double> squares(kCritics * parts);
    team.Run(squares.size(), [&](std::size_t i) {
      const std::size_t of = i / parts;
      squares[i] = critics[of].Gradient(i % parts, critic_input, groups(), value_runs,
                                        critic_gradient.data() + of * networks.critic.size);
    });
    return NormOf(squares);
  }

  double ActorGradient() {
    std::vector<double> squares(actor.gradient_parts());
    team.Run(squares.size(), [&](std::size_t part) {
      squares[part] = actor.Gradient(part, state_input, groups(), runs, actor_gradient.data());
    });
    return NormOf(squares);
  }

  [[nodiscard]] network::SampleGroups groups() const { return {samples}; }

  static double NormOf(const std::vector<double>& squares) {
    double sum = 0;
    for (const double square : squares) sum += square;
    return std::sqrt(sum);
  }

  [[nodiscard]] network::Adam AdamOf(double rate, double norm, std::uint64_t step) const {
    network::AdamStep adam;
    adam.learning_rate = float(rate);
    adam.epsilon = float(sac.adam_epsilon());
    adam.step = step;
    adam.gradient_scale = float(std::min(1.0, sac.max_gradient_norm() / (norm + 1e-6)));
    return network::Adam(adam);
  }

  void DescendCritics(double norm, OptimiserState& state) {
    const network::Adam adam = AdamOf(sac.critic_learning_rate(), norm, state.gradient_steps);
    const std::size_t parts = critics[0].weight_parts();
    team.Run(kCritics * parts, [&](std::size_t i) {
      ForRanges(critics[i / parts], i % parts, i / parts * networks.critic.size,
                [&](std::size_t at, std::size_t count) {
                  adam.Apply(critic_gradient.data() + at, state.critics.data() + at,
                             state.of_critics.m.data() + at, state.of_critics.v.data() + at, count);
                });
    });
    if (sac.shared_heads()) {
      critic_heads.Step(adam, critic_gradient.data(), HeadsDecay(sac.critic_learning_rate()),
                        state.of_critic_heads, state.critics.data());
    }
    team.Run(kCritics * parts, [&](std::size_t i) {
      const std::size_t offset = i / parts * networks.critic.size;
      ForRanges(critics[i / parts], i % parts, offset,
                [&](std::size_t at, std::size_t count) { Follow(at, count, state); });
      critics[i / parts].Pack(i % parts, state.critics.data() + offset);
      targets[i / parts].Pack(i % parts, state.targets.data() + offset);
    });
  }

  [[nodiscard]] float HeadsDecay(double learning_rate) const {
    return float(std::min(1.0, learning_rate * sac.shared_heads_decay()));
  }

  // task(first, count) of the numbers of a part, behind `offset`.
  template <typename Task>
  static void ForRanges(const Mlp& mlp, std::size_t part, std::size_t offset, const Task& task) {
    for (const network::ParameterRange& range : mlp.RangesOf(part)) {
      task(offset + range.first, range.count);
    }
  }

  // target += rate * (critic - target)
  void Follow(std::size_t first, std::size_t count, OptimiserState& state) const {
    const auto rate = float(sac.target_rate());
    for (std::size_t i = first; i < first + count; ++i) {
      state.targets[i] += rate * (state.critics[i] - state.targets[i]);
    }
  }

  void DescendActor(double norm, OptimiserState& state) {
    const network::Adam adam = AdamOf(sac.actor_learning_rate(), norm, state.gradient_steps);
    team.Run(actor.weight_parts(), [&](std::size_t part) {
      ForRanges(actor, part, 0, [&](std::size_t at, std::size_t count) {
        adam.Apply(actor_gradient.data() + at, state.actor.data() + at,
                   state.of_actor.m.data() + at, state.of_actor.v.data() + at, count);
      });
    });
    if (sac.shared_heads()) {
      actor_heads.Step(adam, actor_gradient.data(), HeadsDecay(sac.actor_learning_rate()),
                       state.of_actor_heads, state.actor.data());
    }
    team.Run(actor.weight_parts(), [&](std::size_t part) { actor.Pack(part, state.actor.data()); });
  }

  // Of ln(temperature) * (entropy - wanted entropy), the means over each head's samples. A head
  // without samples stays.
  void DescendTemperatures(const std::vector<HeadSums>& sums, OptimiserState& state) const {
    const network::Adam adam = AdamOf(sac.temperature_learning_rate(), 0, state.gradient_steps);
    const double of_gaussian =
        0.5 + double{policy::kHalfLogTwoPi} + TargetLogStd(gradient_step, config);
    const double wanted = double(networks.actions()) * of_gaussian;
    for (std::size_t head = 0; head < sums.size(); ++head) {
      if (sums[head].samples == 0) continue;
      const auto gradient = float(sums[head].entropy / sums[head].samples - wanted);
      adam.Apply(&gradient, &state.log_temperature[head], &state.of_log_temperature.m[head],
                 &state.of_log_temperature.v[head], 1);
    }
  }

  // ---- Figures.

  [[nodiscard]] StepFigures Sum() const {
    StepFigures sums;
    sums.heads.resize(std::size_t(networks.shape.heads));
    for (std::size_t row = 0; row < samples; ++row) {
      const SampleFigures& of = figures[row];
      const auto head = std::size_t((*batch)[row].head);
      for (const float loss : of.critic_loss) sums.critic_loss += loss / double(kCritics);
      sums.actor_loss += double{temperature[head]} * of.tried.log_prob - of.tried.value;
      sums.heads[head].samples += 1;
      sums.heads[head].entropy -= of.tried.log_prob;
      sums.heads[head].value += of.tried.value;
    }
    sums.critic_loss /= double(samples);
    sums.actor_loss /= double(samples);
    return sums;
  }

  RunConfig config;
  SacConfig sac;
  SacNetworks networks;
  ValueBins bins;
  network::WorkerTeam& team;
  std::size_t samples;
  Mlp actor;
  std::array<Mlp, kCritics> critics;
  std::array<Mlp, kCritics> targets;
  network::SharedHeads actor_heads;
  network::SharedHeads critic_heads;
  // Of the batch in work, its samples in rows.
  const std::vector<Transition>* batch = nullptr;
  policy::Normaliser normaliser{};
  std::vector<HeadRun> runs;
  std::vector<HeadRun> value_runs;
  std::uint64_t gradient_step = 0;
  std::vector<float> temperature;  // [heads]
  Matrix state_input;              // of the actor
  Matrix next_state_input;
  Matrix critic_input;                       // of the critics, with the action that was played
  Matrix tried_input;                        // with the action that the policy tries now
  Matrix next_input;                         // of the next state, with the policy's action
  std::array<Matrix, kCritics> probability;  // of the bins of one value of each critic, at a time
  std::vector<SampleFigures> figures;
  std::vector<float> actor_gradient;
  std::vector<float> critic_gradient;
};

GradientStep::GradientStep(const RunConfig& config, network::WorkerTeam& team)
    : impl_(std::make_unique<Impl>(config, team)) {}

GradientStep::~GradientStep() = default;

void GradientStep::Begin(const OptimiserState& state) {
  Impl& impl = *impl_;
  const std::size_t of_actor = impl.actor.weight_parts();
  const std::size_t parts = impl.critics[0].weight_parts();
  impl.team.Run(of_actor + kCritics * parts, [&](std::size_t i) {
    if (i < of_actor) return impl.actor.Pack(i, state.actor.data());
    const std::size_t of = (i - of_actor) / parts;
    const std::size_t offset = of * impl.networks.critic.size;
    impl.critics[of].Pack((i - of_actor) % parts, state.critics.data() + offset);
    impl.targets[of].Pack((i - of_actor) % parts, state.targets.data() + offset);
  });
}

StepFigures GradientStep::Run(const std::vector<Transition>& batch,
                              const PolicySnapshot& normaliser, OptimiserState& state) {
  Impl& impl = *impl_;
  impl.Take(batch, normaliser);
  impl.gradient_step = state.gradient_steps++;
  impl.temperature.resize(state.log_temperature.size());
  std::transform(state.log_temperature.begin(), state.log_temperature.end(),
                 impl.temperature.begin(), [](float log) { return numbers::Exp(log); });
  impl.ForRows([&](std::size_t first, std::size_t count) { impl.CriticRows(first, count); });
  const double critic_norm = impl.CriticGradient();
  RequireFinite(critic_norm, "critics");
  impl.DescendCritics(critic_norm, state);
  impl.ForRows([&](std::size_t first, std::size_t count) { impl.ActorRows(first, count); });
  const double actor_norm = impl.ActorGradient();
  RequireFinite(actor_norm, "policy");
  impl.DescendActor(actor_norm, state);
  StepFigures figures = impl.Sum();
  figures.critic_gradient_norm = critic_norm;
  figures.actor_gradient_norm = actor_norm;
  impl.DescendTemperatures(figures.heads, state);
  return figures;
}

const std::vector<float>& GradientStep::critic_gradient() const { return impl_->critic_gradient; }

const std::vector<float>& GradientStep::actor_gradient() const { return impl_->actor_gradient; }

}  // namespace metronome::sac
