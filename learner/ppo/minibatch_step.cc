#include "learner/ppo/minibatch_step.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/policy/gaussian.h"
#include "learner/ppo/adam.h"
#include "learner/ppo/mlp.h"
#include "learner/ppo/ppo_loss.h"
#include "learner/ppo/trainer.h"

namespace metronome {
namespace {

constexpr std::size_t kSlice = 4096;  // parameters per task of the reduction and of Adam

// One shard's own memory: no thread touches another's.
struct Shard {
  explicit Shard(const NetworkShape& shape)
      : actor(ActorLayout(shape)), critic(CriticLayout(shape)) {
    gradient.resize(Eigen::Index(actor.layout().size + critic.layout().size));
  }

  Mlp actor;
  Mlp critic;
  std::vector<HeadRun> runs;
  std::vector<HeadRun> value_runs;  // the critic's
  // Actor and critic run as two tasks, so each gathers its input for itself.
  Eigen::MatrixXf actor_input;
  Eigen::MatrixXf critic_input;
  Eigen::MatrixXf d_mean;
  Eigen::MatrixXf d_value;
  Eigen::VectorXf gradient;  // actor, then critic
  double policy_loss = 0;
  double value_loss = 0;
  double entropy = 0;
  std::vector<HeadSums> heads;
};

// Stable counting sort: samples of one head lie together, so that each head is one product.
std::vector<std::uint32_t> OrderByHead(const std::vector<std::uint16_t>& head,
                                       const std::vector<std::uint32_t>& samples,
                                       std::size_t heads) {
  std::vector<std::size_t> begin(heads + 1, 0);
  for (const std::uint32_t sample : samples) ++begin[head[sample] + 1U];
  for (std::size_t i = 1; i <= heads; ++i) begin[i] += begin[i - 1];
  std::vector<std::uint32_t> ordered(samples.size());
  for (const std::uint32_t sample : samples) ordered[begin[head[sample]]++] = sample;
  return ordered;
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

void Gather(const Eigen::MatrixXf& source, const std::uint32_t* samples, std::size_t count,
            Eigen::MatrixXf& target) {
  target.resize(source.rows(), Eigen::Index(count));
  for (std::size_t i = 0; i < count; ++i) target.col(Eigen::Index(i)) = source.col(samples[i]);
}

}  // namespace

struct MinibatchStep::Impl {
  Impl(const RunConfig& config, WorkerTeam& worker_team)
      : shape(ShapeOf(config)),
        actor_layout(ActorLayout(shape)),
        parameter_count(ParameterCount(shape)),
        ppo(config.ppo()),
        team(worker_team),
        gradient(parameter_count) {
    const std::size_t largest = (std::size_t(ppo.minibatch()) + kShardSamples - 1) / kShardSamples;
    for (std::size_t i = 0; i < largest; ++i) shards.emplace_back(shape);
  }

  void PrepareShards(const TrainingBatch& batch) {
    shard_count = (ordered.size() + kShardSamples - 1) / kShardSamples;
    for (std::size_t s = 0; s < shard_count; ++s) {
      Shard& shard = shards.at(s);
      shard.runs.clear();
      for (std::size_t i = 0; i < ShardSize(s); ++i) {
        const std::int32_t head = batch.head[ordered[s * kShardSamples + i]];
        if (shard.runs.empty() || shard.runs.back().head != head) {
          shard.runs.push_back({head, std::int32_t(i), 0});
        }
        ++shard.runs.back().count;
      }
      shard.value_runs = ValueRuns(shard.runs, shape);
    }
  }

  [[nodiscard]] std::size_t ShardSize(std::size_t s) const {
    return std::min(kShardSamples, ordered.size() - s * kShardSamples);
  }

  // Forward, loss and backward of the policy over one shard.
  void ActorTask(const TrainingBatch& batch, const float* parameters, float entropy_coefficient,
                 std::size_t s) {
    Shard& shard = shards[s];
    const std::uint32_t* samples = ordered.data() + s * kShardSamples;
    Gather(batch.input, samples, ShardSize(s), shard.actor_input);
    const Eigen::MatrixXf& mean = shard.actor.Forward(parameters, shard.actor_input, shard.runs);
    shard.d_mean.resize(kActionSize, mean.cols());
    shard.policy_loss = shard.entropy = 0;
    shard.heads.assign(std::size_t(shape.heads), {});
    std::vector<std::array<float, kActionSize>> d_log_std(shard.runs.size());
    for (std::size_t r = 0; r < shard.runs.size(); ++r) {
      PolicyRun(batch, parameters, samples, mean, shard, r, d_log_std[r]);
    }
    shard.actor.Backward(parameters, shard.actor_input, shard.runs, shard.d_mean,
                         shard.gradient.data());
    for (std::size_t r = 0; r < shard.runs.size(); ++r) {
      const HeadRun& run = shard.runs[r];
      float* gradient_of =
          shard.gradient.data() + actor_layout.log_std + std::size_t(run.head) * kActionSize;
      for (int i = 0; i < kActionSize; ++i) {
        gradient_of[i] = (d_log_std[r][i] - entropy_coefficient * float(run.count)) * inv_samples;
      }
    }
  }

  // The loss over the columns of one head: fills d_mean's columns and the head's log-std gradient.
  void PolicyRun(const TrainingBatch& batch, const float* parameters, const std::uint32_t* samples,
                 const Eigen::MatrixXf& mean, Shard& shard, std::size_t r,
                 std::array<float, kActionSize>& d_log_std) const {
    const HeadRun& run = shard.runs[r];
    HeadSums& sums = shard.heads[std::size_t(run.head)];
    const float* log_std = parameters + actor_layout.log_std + std::size_t(run.head) * kActionSize;
    std::array<float, kActionSize> std{};
    for (int i = 0; i < kActionSize; ++i) std[i] = std::exp(log_std[i]);
    for (std::int32_t c = run.begin; c < run.begin + run.count; ++c) {
      const std::uint32_t sample = samples[c];
      PolicySample input;
      input.action = batch.action.col(sample).data();
      input.proximal_log_prob = batch.proximal_log_prob[sample];
      input.behaviour_weight =
          std::exp(batch.proximal_log_prob[sample] - batch.behaviour_log_prob[sample]);
      input.advantage = (batch.advantage[sample] - advantage.mean) * advantage.inv_std;
      const PolicyLoss loss =
          ComputePolicyLoss(input, mean.col(c).data(), std.data(), log_std, float(ppo.clip()));
      for (int i = 0; i < kActionSize; ++i) {
        shard.d_mean(i, c) = loss.d_mean[i] * inv_samples;
        d_log_std[i] += loss.d_log_std[i];
      }
      shard.policy_loss += loss.loss;
      sums.kl -= loss.log_ratio;
      sums.clipped += loss.clipped ? 1 : 0;
    }
    sums.samples += run.count;
    shard.entropy += double(GaussianEntropy(log_std)) * run.count;
  }

  void CriticTask(const TrainingBatch& batch, const float* parameters, std::size_t s) {
    Shard& shard = shards[s];
    const std::uint32_t* samples = ordered.data() + s * kShardSamples;
    Gather(batch.input, samples, ShardSize(s), shard.critic_input);
    const float* block = parameters + actor_layout.size;
    const Eigen::MatrixXf& value =
        shard.critic.Forward(block, shard.critic_input, shard.value_runs);
    shard.d_value.resize(1, value.cols());
    shard.value_loss = 0;
    const float weight = float(ppo.value_coefficient()) * inv_samples;
    for (Eigen::Index c = 0; c < value.cols(); ++c) {
      const float error = value(0, c) - batch.target[samples[c]];
      shard.value_loss += 0.5 * double{error} * error;
      shard.d_value(0, c) = weight * error;
    }
    shard.critic.Backward(block, shard.critic_input, shard.value_runs, shard.d_value,
                          shard.gradient.data() + actor_layout.size);
  }

  // Sums the shards' gradients in shard order; returns the norm of the sum.
  double Reduce() {
    const std::size_t slices = (parameter_count + kSlice - 1) / kSlice;
    std::vector<double> squares(slices, 0);
    team.Run(slices, [&](std::size_t slice) {
      const std::size_t begin = slice * kSlice;
      const std::size_t end = std::min(begin + kSlice, parameter_count);
      std::copy(shards[0].gradient.data() + begin, shards[0].gradient.data() + end,
                gradient.data() + begin);
      for (std::size_t s = 1; s < shard_count; ++s) {
        const float* of_shard = shards[s].gradient.data();
        for (std::size_t i = begin; i < end; ++i) gradient[i] += of_shard[i];
      }
      for (std::size_t i = begin; i < end; ++i) squares[slice] += double{gradient[i]} * gradient[i];
    });
    double sum = 0;
    for (const double square : squares) sum += square;
    return std::sqrt(sum);
  }

  void Descend(double learning_rate, double norm, OptimiserState& state) {
    AdamStep adam;
    adam.learning_rate = float(learning_rate);
    adam.epsilon = float(ppo.adam_epsilon());
    adam.step = ++state.adam_steps;
    adam.gradient_scale = float(std::min(1.0, ppo.max_gradient_norm() / (norm + 1e-6)));
    team.Run((parameter_count + kSlice - 1) / kSlice, [&](std::size_t slice) {
      const std::size_t begin = slice * kSlice;
      const std::size_t count = std::min(kSlice, parameter_count - begin);
      ApplyAdam(adam, gradient.data() + begin, state.parameters.data() + begin,
                state.adam_m.data() + begin, state.adam_v.data() + begin, count);
    });
  }

  MinibatchSums Collect() const {
    MinibatchSums sums;
    sums.heads.resize(std::size_t(shape.heads));
    for (std::size_t s = 0; s < shard_count; ++s) {
      const Shard& shard = shards[s];
      sums.policy_loss += shard.policy_loss;
      sums.value_loss += shard.value_loss;
      sums.entropy += shard.entropy;
      for (std::size_t head = 0; head < sums.heads.size(); ++head) {
        sums.heads[head].samples += shard.heads[head].samples;
        sums.heads[head].kl += shard.heads[head].kl;
        sums.heads[head].clipped += shard.heads[head].clipped;
      }
    }
    return sums;
  }

  NetworkShape shape;
  MlpLayout actor_layout;
  std::size_t parameter_count;
  PpoConfig ppo;
  WorkerTeam& team;
  std::vector<Shard> shards;
  std::vector<float> gradient;
  // Of the minibatch in work.
  std::vector<std::uint32_t> ordered;
  std::size_t shard_count = 0;
  float inv_samples = 0;
  Moments advantage;
};

MinibatchStep::MinibatchStep(const RunConfig& config, WorkerTeam& team)
    : impl_(std::make_unique<Impl>(config, team)) {}

MinibatchStep::~MinibatchStep() = default;

MinibatchSums MinibatchStep::Run(const TrainingBatch& batch,
                                 const std::vector<std::uint32_t>& samples,
                                 const StepSettings& settings, OptimiserState& state) {
  Impl& impl = *impl_;
  impl.ordered = OrderByHead(batch.head, samples, std::size_t(impl.shape.heads));
  impl.inv_samples = 1.0F / float(samples.size());
  impl.advantage = AdvantageMoments(batch.advantage, samples);
  impl.PrepareShards(batch);
  const float* parameters = state.parameters.data();
  impl.team.Run(2 * impl.shard_count, [&](std::size_t task) {
    if (task % 2 == 0) {
      impl.ActorTask(batch, parameters, float(settings.entropy_coefficient), task / 2);
    } else {
      impl.CriticTask(batch, parameters, task / 2);
    }
  });
  MinibatchSums sums = impl.Collect();
  sums.gradient_norm = impl.Reduce();
  if (!std::isfinite(sums.gradient_norm)) {
    throw NonFiniteUpdate("the gradient is not finite (norm " + std::to_string(sums.gradient_norm) +
                          ")");
  }
  impl.Descend(settings.learning_rate, sums.gradient_norm, state);
  return sums;
}

const std::vector<float>& MinibatchStep::gradient() const { return impl_->gradient; }

}  // namespace metronome
