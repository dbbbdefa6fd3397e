#include "learner/ppo/minibatch_step.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/policy/gaussian.h"
#include "learner/algorithm/algorithm.h"
#include "learner/ppo/adam.h"
#include "learner/ppo/gradient_reducer.h"
#include "learner/ppo/mlp.h"
#include "learner/ppo/ppo_loss.h"

namespace metronome::ppo {
namespace {

constexpr std::size_t kSlice = 4096;  // parameters per task of Adam

using ActionArray = std::array<float, kMaxActionSize>;  // the first shape.action numbers count

struct Shard {
  std::vector<HeadRun> runs;
  std::vector<HeadRun> value_runs;  // the critic's
};

// One group's own memory, but for its gradient: no thread touches another's.
struct Group {
  explicit Group(const policy::NetworkShape& shape)
      : actor(policy::ActorLayout(shape)), critic(policy::CriticLayout(shape)) {}

  Mlp actor;
  Mlp critic;
  // Actor and critic run as two tasks, so each gathers its input for itself.
  Eigen::MatrixXf actor_input;
  Eigen::MatrixXf critic_input;
  Eigen::MatrixXf d_mean;
  Eigen::MatrixXf d_value;
  double policy_loss = 0;
  double value_loss = 0;
  double entropy = 0;
  std::vector<HeadSums> heads;
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

void Gather(const Eigen::MatrixXf& source, const std::uint32_t* samples, std::size_t count,
            Eigen::MatrixXf& target) {
  target.resize(source.rows(), Eigen::Index(count));
  for (std::size_t i = 0; i < count; ++i) target.col(Eigen::Index(i)) = source.col(samples[i]);
}

}  // namespace

struct MinibatchStep::Impl {
  Impl(const RunConfig& config, WorkerTeam& worker_team)
      : shape(policy::ShapeOf(config)),
        actor_layout(policy::ActorLayout(shape)),
        parameter_count(policy::ParameterCount(shape)),
        ppo(config.ppo()),
        team(worker_team),
        groups(MostGroups(ppo), Group(shape)),
        reducer(groups.size(), parameter_count, team) {}

  static std::size_t ShardsOf(std::size_t samples) {
    return (samples + kShardSamples - 1) / kShardSamples;
  }

  // A last minibatch that is smaller never has more groups than a whole one has at most.
  static std::size_t MostGroups(const PpoConfig& ppo) {
    return std::min(ShardsOf(std::size_t(ppo.minibatch())), ShardGroups::kMostGroups);
  }

  void PrepareShards(const TrainingBatch& batch) {
    shards.assign(ShardsOf(by_head.size()), {});
    grouping = ShardGroups::Of(shards.size());
    for (std::size_t s = 0; s < shards.size(); ++s) {
      Shard& shard = shards[s];
      for (std::size_t i = 0; i < ShardSize(s); ++i) {
        const std::int32_t head = batch.head[by_head[s * kShardSamples + i]];
        if (shard.runs.empty() || shard.runs.back().head != head) {
          shard.runs.push_back({head, std::int32_t(i), 0});
        }
        ++shard.runs.back().count;
      }
      shard.value_runs = ValueRuns(shard.runs, shape);
    }
  }

  [[nodiscard]] std::size_t ShardSize(std::size_t s) const {
    return std::min(kShardSamples, by_head.size() - s * kShardSamples);
  }

  // Forward, loss and backward of the policy over the shards of one group, in order.
  void ActorTask(const TrainingBatch& batch, const float* parameters, float entropy_coefficient,
                 std::size_t g) {
    Group& group = groups[g];
    group.policy_loss = group.entropy = 0;
    group.heads.assign(std::size_t(shape.heads), {});
    float* gradient = reducer.Of(g);
    std::fill_n(gradient, actor_layout.size, 0.0F);
    for (std::size_t s = grouping.begin(g); s < grouping.end(g); ++s) {
      AddActorShard(batch, parameters, entropy_coefficient, s, group, gradient);
    }
  }

  void AddActorShard(const TrainingBatch& batch, const float* parameters, float entropy_coefficient,
                     std::size_t s, Group& group, float* gradient) const {
    const std::vector<HeadRun>& runs = shards[s].runs;
    const std::uint32_t* samples = by_head.data() + s * kShardSamples;
    Gather(batch.input, samples, ShardSize(s), group.actor_input);
    const Eigen::MatrixXf& mean = group.actor.Forward(parameters, group.actor_input, runs);
    group.d_mean.resize(shape.action, mean.cols());
    std::vector<ActionArray> d_log_std(runs.size());
    for (std::size_t r = 0; r < runs.size(); ++r) {
      PolicyRun(batch, parameters, samples, mean, runs[r], group, d_log_std[r]);
    }
    group.actor.Backward(parameters, group.actor_input, runs, group.d_mean, gradient);
    for (std::size_t r = 0; r < runs.size(); ++r) {
      float* gradient_of =
          gradient + actor_layout.log_std + std::size_t(runs[r].head) * std::size_t(shape.action);
      for (int i = 0; i < shape.action; ++i) {
        gradient_of[i] +=
            (d_log_std[r][i] - entropy_coefficient * float(runs[r].count)) * inv_samples;
      }
    }
  }

  // The loss over the columns of one head: fills d_mean's columns and the head's log-std gradient.
  void PolicyRun(const TrainingBatch& batch, const float* parameters, const std::uint32_t* samples,
                 const Eigen::MatrixXf& mean, const HeadRun& run, Group& group,
                 ActionArray& d_log_std) const {
    HeadSums& sums = group.heads[std::size_t(run.head)];
    const float* log_std =
        parameters + actor_layout.log_std + std::size_t(run.head) * std::size_t(shape.action);
    ActionArray std{};
    for (int i = 0; i < shape.action; ++i) std[i] = std::exp(log_std[i]);
    for (std::int32_t c = run.begin; c < run.begin + run.count; ++c) {
      const std::uint32_t sample = samples[c];
      PolicySample input;
      input.action = batch.action.col(sample).data();
      input.proximal_log_prob = batch.proximal_log_prob[sample];
      input.behaviour_weight =
          std::exp(batch.proximal_log_prob[sample] - batch.behaviour_log_prob[sample]);
      input.advantage = (batch.advantage[sample] - advantage.mean) * advantage.inv_std;
      const PolicyLoss loss = ComputePolicyLoss(input, mean.col(c).data(), std.data(), log_std,
                                                shape.action, float(ppo.clip()));
      for (int i = 0; i < shape.action; ++i) {
        group.d_mean(i, c) = loss.d_mean[i] * inv_samples;
        d_log_std[i] += loss.d_log_std[i];
      }
      group.policy_loss += loss.loss;
      sums.kl -= loss.log_ratio;
      sums.clipped += loss.clipped ? 1 : 0;
    }
    sums.samples += run.count;
    group.entropy += double(policy::GaussianEntropy(log_std, shape.action)) * run.count;
  }

  void CriticTask(const TrainingBatch& batch, const float* parameters, std::size_t g) {
    Group& group = groups[g];
    group.value_loss = 0;
    float* gradient = reducer.Of(g) + actor_layout.size;
    std::fill_n(gradient, parameter_count - actor_layout.size, 0.0F);
    for (std::size_t s = grouping.begin(g); s < grouping.end(g); ++s) {
      AddCriticShard(batch, parameters + actor_layout.size, s, group, gradient);
    }
  }

  // @param block, gradient  of the critic.
  void AddCriticShard(const TrainingBatch& batch, const float* block, std::size_t s, Group& group,
                      float* gradient) const {
    const std::vector<HeadRun>& runs = shards[s].value_runs;
    const std::uint32_t* samples = by_head.data() + s * kShardSamples;
    Gather(batch.input, samples, ShardSize(s), group.critic_input);
    const Eigen::MatrixXf& value = group.critic.Forward(block, group.critic_input, runs);
    group.d_value.resize(1, value.cols());
    const float weight = float(ppo.value_coefficient()) * inv_samples;
    for (Eigen::Index c = 0; c < value.cols(); ++c) {
      const float error = value(0, c) - batch.target[samples[c]];
      group.value_loss += 0.5 * double{error} * error;
      group.d_value(0, c) = weight * error;
    }
    group.critic.Backward(block, group.critic_input, runs, group.d_value, gradient);
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
      ApplyAdam(adam, reducer.sum().data() + begin, state.parameters.data() + begin,
                state.adam_m.data() + begin, state.adam_v.data() + begin, count);
    });
  }

  MinibatchSums Collect() const {
    MinibatchSums sums;
    sums.heads.resize(std::size_t(shape.heads));
    for (std::size_t g = 0; g < grouping.count(); ++g) {
      const Group& group = groups[g];
      sums.policy_loss += group.policy_loss;
      sums.value_loss += group.value_loss;
      sums.entropy += group.entropy;
      for (std::size_t head = 0; head < sums.heads.size(); ++head) {
        sums.heads[head].samples += group.heads[head].samples;
        sums.heads[head].kl += group.heads[head].kl;
        sums.heads[head].clipped += group.heads[head].clipped;
      }
    }
    return sums;
  }

  policy::NetworkShape shape;
  policy::MlpLayout actor_layout;
  std::size_t parameter_count;
  PpoConfig ppo;
  WorkerTeam& team;
  std::vector<Group> groups;
  GradientReducer reducer;
  // Of the minibatch in work.
  std::vector<std::uint32_t> by_head;
  std::vector<Shard> shards;
  ShardGroups grouping;
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
  impl.by_head = SortByHead(batch.head, samples, std::size_t(impl.shape.heads));
  impl.inv_samples = 1.0F / float(samples.size());
  impl.advantage = AdvantageMoments(batch.advantage, samples);
  impl.PrepareShards(batch);
  const float* parameters = state.parameters.data();
  impl.team.Run(2 * impl.grouping.count(), [&](std::size_t task) {
    if (task % 2 == 0) {
      impl.ActorTask(batch, parameters, float(settings.entropy_coefficient), task / 2);
    } else {
      impl.CriticTask(batch, parameters, task / 2);
    }
  });
  MinibatchSums sums = impl.Collect();
  sums.gradient_norm = impl.reducer.Reduce(impl.grouping.count());
  if (!std::isfinite(sums.gradient_norm)) {
    throw algorithm::NonFiniteUpdate("the gradient is not finite (norm " +
                                     std::to_string(sums.gradient_norm) + ")");
  }
  impl.Descend(settings.learning_rate, sums.gradient_norm, state);
  return sums;
}

const std::vector<float>& MinibatchStep::gradient() const { return impl_->reducer.sum(); }

std::size_t MinibatchStep::gradients_held() const { return impl_->reducer.groups_held(); }

}  // namespace metronome::ppo
