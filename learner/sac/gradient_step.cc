#include "learner/sac/gradient_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "common/kernels/matrix.h"
#include "common/numbers/elementary.h"
#include "common/numbers/random.h"
#include "common/policy/squashed_gaussian.h"
#include "learner/algorithm/algorithm.h"
#include "learner/network/mlp.h"
#include "learner/sac/batch_rows.h"
#include "learner/sac/descent.h"
#include "learner/sac/sac_networks.h"
#include "learner/sac/step_networks.h"
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
        layouts(run_config),
        bins(layouts.bins, float(run_config.sac().value_limit())),
        team(worker_team),
        samples(std::size_t(run_config.sac().batch())),
        networks(layouts, samples),
        descent(run_config, networks, worker_team),
        rows(run_config),
        probability{Matrix(samples, layouts.bins), Matrix(samples, layouts.bins)},
        figures(samples),
        actor_gradient(layouts.actor.size),
        critic_gradient(kCritics * layouts.critic.size) {}

  void Take(const std::vector<Transition>& batch, const PolicySnapshot& normaliser,
            const OptimiserState& state) {
    rows.Take(batch, normaliser);
    gradient_step = state.gradient_steps;
    temperature.resize(state.log_temperature.size());
    std::transform(state.log_temperature.begin(), state.log_temperature.end(), temperature.begin(),
                   [](float log) { return numbers::Exp(log); });
  }

  // ---- Rows of the batch: passes and losses.

  // The policy's action by its outputs of this row. @param which  0: of the next state, 1: of the
  // state.
  Tried Try(std::size_t row, std::uint64_t which) const {
    const float* output = networks.actor.output().row(row);
    const std::size_t actions = layouts.actions();
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
    std::copy_n(critic.output().row(row), layouts.bins, p);
    Softmax(p, 1, layouts.bins, probability[which].stride());
    return bins.Mean(p);
  }

  void CriticRows(std::size_t first, std::size_t count) {
    for (std::size_t row = first; row < first + count; ++row) rows.Gather(row);
    const std::vector<HeadRun> next_runs = rows.NextRuns(first, count);
    networks.actor.Forward(rows.next_state, first, count, next_runs);
    for (std::size_t row = first; row < first + count; ++row) {
      rows.TryNext(row, Try(row, 0).action.data());
    }
    const std::vector<HeadRun> next_values = policy::ValueRuns(next_runs, layouts.shape);
    for (Mlp& target : networks.targets) target.Forward(rows.next, first, count, next_values);
    const std::vector<HeadRun> values = policy::ValueRuns(rows.Runs(first, count), layouts.shape);
    for (Mlp& critic : networks.critics) critic.Forward(rows.played, first, count, values);
    for (std::size_t row = first; row < first + count; ++row) CriticLosses(row);
    for (Mlp& critic : networks.critics) critic.Backward(first, count, values);
  }

  [[nodiscard]] float Target(std::size_t row) {
    const Transition& transition = rows.of(row);
    if (transition.next_discount == 0) return transition.reward;
    const float next =
        std::min(ValueOf(networks.targets[0], 0, row), ValueOf(networks.targets[1], 1, row));
    return transition.reward + transition.next_discount * ValueBins::Symexp(next);
  }

  // Cross-entropy of the target's two bins by the critic's distribution.
  void CriticLosses(std::size_t row) {
    const ValueBins::TwoHot target = bins.Share(ValueBins::Symlog(Target(row)));
    for (std::size_t i = 0; i < kCritics; ++i) {
      ValueOf(networks.critics[i], i, row);
      const float* p = probability[i].row(row);
      float* d = networks.critics[i].d_output().row(row);
      for (std::size_t bin = 0; bin < layouts.bins; ++bin) d[bin] = p[bin] * inv_samples();
      d[target.low] -= target.of_low * inv_samples();
      d[target.low + 1] -= target.of_high * inv_samples();
      figures[row].critic_loss[i] =
          float(-target.of_low * numbers::Log(double{p[target.low]} + 1e-30) -
                target.of_high * numbers::Log(double{p[target.low + 1]} + 1e-30));
    }
  }

  void ActorRows(std::size_t first, std::size_t count) {
    const std::vector<HeadRun> of_rows = rows.Runs(first, count);
    const std::vector<HeadRun> values = policy::ValueRuns(of_rows, layouts.shape);
    networks.actor.Forward(rows.state, first, count, of_rows);
    for (std::size_t row = first; row < first + count; ++row) {
      figures[row].tried = Try(row, 1);
      rows.Try(row, figures[row].tried.action.data());
    }
    for (Mlp& critic : networks.critics) critic.Forward(rows.tried, first, count, values);
    for (std::size_t row = first; row < first + count; ++row) ValueGradient(row);
    for (Mlp& critic : networks.critics) critic.Backward(first, count, values);
    for (std::size_t row = first; row < first + count; ++row) ActorGradientOfOutputs(row);
    networks.actor.Backward(first, count, of_rows);
  }

  // Of minus the lesser critic's value, by its logits: dv/dz_i = p_i (b_i - v).
  void ValueGradient(std::size_t row) {
    const float first = ValueOf(networks.critics[0], 0, row);
    const float second = ValueOf(networks.critics[1], 1, row);
    const std::size_t lesser = first < second ? 0 : 1;
    const float value = std::min(first, second);
    const float* p = probability[lesser].row(row);
    float* d = networks.critics[lesser].d_output().row(row);
    for (std::size_t bin = 0; bin < layouts.bins; ++bin) {
      d[bin] = -p[bin] * (bins.bins()[bin] - value) * inv_samples();
    }
    std::fill_n(networks.critics[1 - lesser].d_output().row(row), layouts.bins, 0.0F);
    figures[row].tried.value = value;
  }

  // Of temperature * log-density - value, by mean and log-std of the squashed Gaussian: u = mean +
  // std * noise, action = tanh(u); the log-density falls by ln(1 - action^2).
  void ActorGradientOfOutputs(std::size_t row) {
    const Tried& tried = figures[row].tried;
    const std::size_t actions = layouts.actions();
    const float weight = temperature[std::size_t(rows.of(row).head)] * inv_samples();
    const float* output = networks.actor.output().row(row);
    float* d = networks.actor.d_output().row(row);
    for (std::size_t i = 0; i < actions; ++i) {
      const float a = tried.action[i];
      const float d_action =
          networks.critics[0].d_input().row(row)[i] + networks.critics[1].d_input().row(row)[i];
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

  // ---- Gradients, of all rows.

  // @return the norm of both critics' gradients together.
  double CriticGradient() {
    const std::size_t parts = networks.critics[0].gradient_parts();
    const std::vector<HeadRun> values = policy::ValueRuns(rows.Runs(0, samples), layouts.shape);
    std::vector<double> squares(kCritics * parts);
    team.Run(squares.size(), [&](std::size_t i) {
      const std::size_t of = i / parts;
      squares[i] = networks.critics[of].Gradient(i % parts, rows.played, {samples}, values,
                                                 critic_gradient.data() + of * layouts.critic.size);
    });
    return NormOf(squares);
  }

  double ActorGradient() {
    const std::vector<HeadRun> runs = rows.Runs(0, samples);
    std::vector<double> squares(networks.actor.gradient_parts());
    team.Run(squares.size(), [&](std::size_t part) {
      squares[part] =
          networks.actor.Gradient(part, rows.state, {samples}, runs, actor_gradient.data());
    });
    return NormOf(squares);
  }

  static double NormOf(const std::vector<double>& squares) {
    double sum = 0;
    for (const double square : squares) sum += square;
    return std::sqrt(sum);
  }

  // ---- Figures.

  [[nodiscard]] StepFigures Sum() const {
    StepFigures sums;
    sums.heads.resize(std::size_t(layouts.shape.heads));
    for (std::size_t row = 0; row < samples; ++row) {
      const SampleFigures& of = figures[row];
      const auto head = std::size_t(rows.of(row).head);
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
  SacNetworks layouts;
  ValueBins bins;
  network::WorkerTeam& team;
  std::size_t samples;
  StepNetworks networks;
  Descent descent;
  // Of the batch in work.
  BatchRows rows;
  std::uint64_t gradient_step = 0;
  std::vector<float> temperature;            // [heads]
  std::array<Matrix, kCritics> probability;  // of the bins of one value of each critic, at a time
  std::vector<SampleFigures> figures;
  std::vector<float> actor_gradient;
  std::vector<float> critic_gradient;
};

GradientStep::GradientStep(const RunConfig& config, network::WorkerTeam& team)
    : impl_(std::make_unique<Impl>(config, team)) {}

GradientStep::~GradientStep() = default;

void GradientStep::Begin(const OptimiserState& state) { impl_->networks.Pack(state, impl_->team); }

StepFigures GradientStep::Run(const std::vector<Transition>& batch,
                              const PolicySnapshot& normaliser, OptimiserState& state) {
  Impl& impl = *impl_;
  impl.Take(batch, normaliser, state);
  ++state.gradient_steps;
  impl.ForRows([&](std::size_t first, std::size_t count) { impl.CriticRows(first, count); });
  const double critic_norm = impl.CriticGradient();
  RequireFinite(critic_norm, "critics");
  impl.descent.Critics(impl.critic_gradient, critic_norm, state);
  impl.ForRows([&](std::size_t first, std::size_t count) { impl.ActorRows(first, count); });
  const double actor_norm = impl.ActorGradient();
  RequireFinite(actor_norm, "policy");
  impl.descent.Actor(impl.actor_gradient, actor_norm, state);
  StepFigures figures = impl.Sum();
  figures.critic_gradient_norm = critic_norm;
  figures.actor_gradient_norm = actor_norm;
  impl.descent.Temperatures(figures.heads, state);
  return figures;
}

const std::vector<float>& GradientStep::critic_gradient() const { return impl_->critic_gradient; }

const std::vector<float>& GradientStep::actor_gradient() const { return impl_->actor_gradient; }

}  // namespace metronome::sac
