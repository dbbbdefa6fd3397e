#include "learner/ppo/minibatch_step.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/numbers/elementary.h"
#include "common/policy/gaussian.h"
#include "learner/algorithm/algorithm.h"
#include "learner/network/adam.h"
#include "learner/network/mlp.h"
#include "learner/ppo/ppo_loss.h"

namespace metronome::ppo {
namespace {

using policy::HeadRun;
using ActionArray = std::array<float, kMaxActionSize>;  // the first shape.action numbers count

constexpr std::size_t kRows = policy::PackedNetwork::kRows;

// What the passes over a sample leave for the sums over all of them.
struct SampleFigures {
  float policy_loss = 0;
  float log_ratio = 0;
  double value_loss = 0;
  bool clipped = false;
};

// Stable counting sort: samples of one head lie together, so that each head is one product.
std::vector<std::uint32_t> SortByHead(const std::vector<std::uint16_t>& head,
                                      const std::vector<std::uint32_t>& samples,
                                      std::size_t heads) {
  std::vector<std::size_t> begin(heads + 1, 0);
  for (const std::uint32_t sample : samples) ++begin[head[sample] + 1U];
  for (std::size_t i = 1; i <= heads; ++i) begin[i] += begin[i - 1];
  std::vector<std::uint32_t> by_head(samples.size());
  for (const std::uint32_t sample : samples) by_head[begin[head[sample]]++] = sample;
  return by_head;
}

struct Moments {
  float mean = 0;
  float inv_std = 1;
};

// Mean and 1 / (sample standard deviation + 1e-8) of the minibatch's advantages.
Moments AdvantageMoments(const std::vector<float>& advantage,
                         const std::vector<std::uint32_t>& samples) {
  double sum = 0;
  for (const std::uint32_t sample : samples) sum += advantage[sample];
  const double mean = sum / double(samples.size());
  double squares = 0;
  for (const std::uint32_t sample : samples) {
    squares += (advantage[sample] - mean) * (advantage[sample] - mean);
  }
  const double variance = squares / std::max(1.0, double(samples.size()) - 1);
  return {float(mean), float(1 / (std::sqrt(variance) + 1e-8))};
}

// Of rows [first, first + count).
std::vector<HeadRun> RunsOf(const std::vector<std::uint16_t>& heads, std::size_t first,
                            std::size_t count) {
  std::vector<HeadRun> runs;
  for (std::size_t row = first; row < first + count; ++row) {
    policy::AddRow(heads[row], row, runs);
  }
  return runs;
}

}  // namespace

struct MinibatchStep::Impl {
  Impl(const RunConfig& config, network::WorkerTeam& worker_team)
      : shape(policy::ShapeOf(config)),
        ppo(config.ppo()),
        team(worker_team),
        actor(policy::ActorLayout(shape), MostSamples(config)),
        critic(policy::CriticLayout(shape), MostSamples(config)),
        actor_size(actor.layout().size),
        shared_heads(shape),
        gradient(policy::ParameterCount(shape)),
        input(MostSamples(config), std::size_t(shape.critic_input())),
        d_log_std(MostSamples(config)),
        figures(MostSamples(config)) {}

  static std::size_t MostSamples(const RunConfig& config) {
    return std::min(std::size_t(config.ppo().minibatch()),
                    std::size_t(config.collection().episodes_per_update()) *
                        std::size_t(config.environment().horizon()) *
                        std::size_t(1 + config.ppo().earlier_batches()));
  }

  void Sort(const TrainingBatch& batch, const std::vector<std::uint32_t>& samples) {
    by_head = SortByHead(batch.head, samples, std::size_t(shape.heads));
    heads.resize(by_head.size());
    for (std::size_t row = 0; row < by_head.size(); ++row) heads[row] = batch.head[by_head[row]];
    runs = RunsOf(heads, 0, heads.size());
    value_runs = policy::ValueRuns(runs, shape);
    groups = {by_head.size()};
  }

  // The input of rows [first, first + count).
  void Gather(const TrainingBatch& batch, std::size_t first, std::size_t count) {
    for (std::size_t row = first; row < first + count; ++row) {
      std::copy_n(batch.input.row(by_head[row]), input.columns(), input.row(row));
    }
  }

  // Forward, losses and backward of both networks.
  void PassRows(const TrainingBatch& batch, const float* parameters, std::size_t first,
                std::size_t count) {
    const std::vector<HeadRun> of_rows = RunsOf(heads, first, count);
    const std::vector<HeadRun> of_values = policy::ValueRuns(of_rows, shape);
    Gather(batch, first, count);
    actor.Forward(input, first, count, of_rows);
    for (const HeadRun& run : of_rows) PolicyLosses(batch, parameters, run);
    actor.Backward(first, count, of_rows);
    critic.Forward(input, first, count, of_values);
    ValueLosses(batch, first, count);
    critic.Backward(first, count, of_values);
  }

  void PolicyLosses(const TrainingBatch& batch, const float* parameters, const HeadRun& run) {
    const float* log_std = parameters + LogStd(run.head);
    const ActionArray inv_std = policy::InverseStd(log_std, shape.action);
    for (std::size_t row = run.begin; row < run.end(); ++row) {
      const std::uint32_t sample = by_head[row];
      PolicySample of;
      of.action = batch.action.row(sample);
      of.proximal_log_prob = batch.proximal_log_prob[sample];
      of.behaviour_weight = batch.behaviour_weight[sample];
      of.advantage = (batch.advantage[sample] - advantage.mean) * advantage.inv_std;
      const PolicyLoss loss = ComputePolicyLoss(of, actor.output().row(row), inv_std.data(),
                                                log_std, shape.action, float(ppo.clip()));
      for (int i = 0; i < shape.action; ++i) {
        actor.d_output().row(row)[i] = loss.d_mean[i] * inv_samples;
      }
      d_log_std[row] = loss.d_log_std;
      figures[row].policy_loss = loss.loss;
      figures[row].log_ratio = loss.log_ratio;
      figures[row].clipped = loss.clipped;
    }
  }

  void ValueLosses(const TrainingBatch& batch, std::size_t first, std::size_t count) {
    const float weight = float(ppo.value_coefficient()) * inv_samples;
    for (std::size_t row = first; row < first + count; ++row) {
      figures[row].value_loss = 0;
      for (std::size_t part = 0; part < batch.rewards.size(); ++part) {
        const float error =
            critic.output().row(row)[part] - batch.rewards[part].target[by_head[row]];
        figures[row].value_loss += 0.5 * double{error} * error;
        critic.d_output().row(row)[part] = weight * error;
      }
    }
  }

  // Equally many tasks for each thread, of about kRows rows.
  void Pass(const TrainingBatch& batch, const float* parameters) {
    const std::size_t samples = by_head.size();
    const std::size_t rounds = (samples + kRows * team.threads() - 1) / (kRows * team.threads());
    const std::size_t tasks = rounds * team.threads();
    team.Run(tasks, [&](std::size_t task) {
      const std::size_t first = task * samples / tasks;
      const std::size_t end = (task + 1) * samples / tasks;
      if (end > first) PassRows(batch, parameters, first, end - first);
    });
  }

  // The gradient. @return its norm.
  double SumGradient(const float* parameters, float entropy_coefficient, MinibatchSums& sums) {
    const std::size_t of_actor = actor.gradient_parts();
    const std::size_t parts = of_actor + critic.gradient_parts();
    std::vector<double> squares(parts + 1);
    team.Run(parts + 1, [&](std::size_t part) {
      if (part < of_actor) {
        squares[part] = actor.Gradient(part, input, groups, runs, gradient.data());
      } else if (part < parts) {
        squares[part] = critic.Gradient(part - of_actor, input, groups, value_runs,
                                        gradient.data() + actor_size);
      } else {
        squares[part] = LogStdGradient(entropy_coefficient);
        SumFigures(parameters, sums);
      }
    });
    double sum = 0;
    for (const double square : squares) sum += square;
    return std::sqrt(sum);
  }

  // By the same rule as weights. @return the sum of its squares.
  double LogStdGradient(float entropy_coefficient) {
    float* of_heads = gradient.data() + actor.layout().log_std;
    std::fill_n(of_heads, shape.heads * shape.action, 0.0F);
    double squares = 0;
    for (const HeadRun& run : runs) {
      ActionArray sum = SumOverGroups(run);
      for (int i = 0; i < shape.action; ++i) {
        const float d = (sum[i] - entropy_coefficient * float(run.count)) * inv_samples;
        of_heads[run.head * shape.action + i] = d;
        squares += double{d} * d;
      }
    }
    return squares;
  }

  [[nodiscard]] ActionArray SumOverGroups(const HeadRun& run) const {
    ActionArray sum{};
    for (std::size_t g = 0; g < network::SampleGroups::kGroups; ++g) {
      const HeadRun part = groups.PartOf(run, g);
      ActionArray chain{};
      for (std::size_t row = part.begin; row < part.end(); ++row) {
        for (int i = 0; i < shape.action; ++i) chain[i] += d_log_std[row][i];
      }
      for (int i = 0; i < shape.action; ++i) sum[i] += chain[i];
    }
    return sum;
  }

  void SumFigures(const float* parameters, MinibatchSums& sums) const {
    sums.heads.resize(std::size_t(shape.heads));
    for (const HeadRun& run : runs) {
      HeadSums& head = sums.heads[std::size_t(run.head)];
      head.samples = double(run.count);
      for (std::size_t row = run.begin; row < run.end(); ++row) {
        const SampleFigures& of = figures[row];
        head.kl -= of.log_ratio;
        head.clipped += of.clipped ? 1 : 0;
        sums.policy_loss += of.policy_loss;
        sums.value_loss += of.value_loss;
      }
      sums.entropy += double{policy::GaussianEntropy(parameters + LogStd(run.head), shape.action)} *
                      double(run.count);
    }
  }

  void Descend(const StepSettings& settings, double norm, OptimiserState& state) {
    network::AdamStep adam;
    adam.learning_rate = float(settings.learning_rate);
    adam.epsilon = float(ppo.adam_epsilon());
    adam.step = ++state.adam_steps;
    adam.gradient_scale = float(std::min(1.0, ppo.max_gradient_norm() / (norm + 1e-6)));
    const network::Adam step(adam);
    adam.learning_rate *= float(ppo.log_std_rate());
    const network::Adam of_log_stds(adam);
    const auto apply = [&](const network::Adam& by, std::size_t first, std::size_t count) {
      by.Apply(gradient.data() + first, state.parameters.data() + first,
               state.adam_m.data() + first, state.adam_v.data() + first, count);
    };
    ForEachPart([&](network::Mlp& mlp, std::size_t part, std::size_t offset) {
      for (const network::ParameterRange& range : mlp.RangesOf(part)) {
        apply(step, offset + range.first, range.count);
      }
      mlp.Pack(part, state.parameters.data() + offset);
    });
    apply(of_log_stds, actor.layout().log_std,
          std::size_t(shape.heads) * std::size_t(shape.action));
    if (ppo.shared_heads()) ShareHeads(step, settings.learning_rate, state);
    BoundLogStds(settings, state.parameters.data() + actor.layout().log_std);
  }

  void ShareHeads(const network::Adam& step, double learning_rate, OptimiserState& state) {
    const double decay = std::min(1.0, learning_rate * ppo.shared_heads_decay());
    shared_heads.Step(step, gradient.data(), float(decay), state.shared, state.parameters.data());
    actor.PackHeads(state.parameters.data());
    critic.PackHeads(state.parameters.data() + actor_size);
  }

  void BoundLogStds(const StepSettings& settings, float* log_std) const {
    const auto low = float(settings.min_log_std);
    const auto high = float(settings.max_log_std);
    std::transform(log_std, log_std + shape.heads * shape.action, log_std,
                   [low, high](float value) { return std::clamp(value, low, high); });
  }

  // task(mlp, part of its weights, where the network begins among the parameters).
  template <typename Task>
  void ForEachPart(const Task& task) {
    const std::size_t of_actor = actor.weight_parts();
    team.Run(of_actor + critic.weight_parts(), [&](std::size_t part) {
      if (part < of_actor) {
        task(actor, part, 0);
      } else {
        task(critic, part - of_actor, actor_size);
      }
    });
  }

  [[nodiscard]] std::size_t LogStd(std::int32_t head) const {
    return actor.layout().log_std + std::size_t(head) * std::size_t(shape.action);
  }

  policy::NetworkShape shape;
  PpoConfig ppo;
  network::WorkerTeam& team;
  network::Mlp actor;
  network::Mlp critic;
  std::size_t actor_size;
  network::SharedHeads shared_heads;
  std::vector<float> gradient;
  // Of the minibatch in work: its samples in rows.
  std::vector<std::uint32_t> by_head;
  std::vector<std::uint16_t> heads;
  std::vector<HeadRun> runs;
  std::vector<HeadRun> value_runs;  // the critic's
  network::SampleGroups groups;
  kernels::Matrix input;
  std::vector<ActionArray> d_log_std;
  std::vector<SampleFigures> figures;
  float inv_samples = 0;
  Moments advantage;
};

MinibatchStep::MinibatchStep(const RunConfig& config, network::WorkerTeam& team)
    : impl_(std::make_unique<Impl>(config, team)) {}

MinibatchStep::~MinibatchStep() = default;

void MinibatchStep::Begin(const OptimiserState& state) {
  impl_->ForEachPart([&](network::Mlp& mlp, std::size_t part, std::size_t offset) {
    mlp.Pack(part, state.parameters.data() + offset);
  });
}

MinibatchSums MinibatchStep::Run(const TrainingBatch& batch,
                                 const std::vector<std::uint32_t>& samples,
                                 const StepSettings& settings, OptimiserState& state) {
  Impl& impl = *impl_;
  impl.Sort(batch, samples);
  impl.inv_samples = 1.0F / float(samples.size());
  impl.advantage = AdvantageMoments(batch.advantage, samples);
  impl.Pass(batch, state.parameters.data());
  MinibatchSums sums;
  sums.gradient_norm =
      impl.SumGradient(state.parameters.data(), float(settings.entropy_coefficient), sums);
  if (!std::isfinite(sums.gradient_norm)) {
    throw algorithm::NonFiniteUpdate("the gradient is not finite (norm " +
                                     std::to_string(sums.gradient_norm) + ")");
  }
  impl.Descend(settings, sums.gradient_norm, state);
  return sums;
}

const std::vector<float>& MinibatchStep::gradient() const { return impl_->gradient; }

}  // namespace metronome::ppo
