#include "learner/ppo/training_batch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/numbers/elementary.h"
#include "common/policy/gaussian.h"
#include "common/policy/head_schedule.h"
#include "common/policy/network_input.h"
#include "common/policy/packed_network.h"
#include "common/policy/task_of.h"
#include "learner/algorithm/learning_reward.h"
#include "learner/ppo/gae.h"

namespace metronome::ppo {
namespace {

// Where each episode's samples begin, and behind the last where they end.
std::vector<std::size_t> BeginsOf(const std::vector<Episode>& episodes) {
  std::vector<std::size_t> begins = {0};
  for (const Episode& episode : episodes) {
    begins.push_back(begins.back() + std::size_t(episode.length()));
  }
  return begins;
}

using policy::HeadRun;
using policy::PackedNetwork;

// Both networks at the update's start.
struct Networks {
  explicit Networks(const BatchSource& source)
      : shape(policy::ShapeOf(source.config)),
        actor(policy::ActorLayout(shape)),
        critic(policy::CriticLayout(shape)),
        log_std(source.parameters + actor.log_std),
        packed_actor(actor, source.parameters),
        packed_critic(critic, source.parameters + actor.size) {}

  policy::NetworkShape shape;
  policy::MlpLayout actor;
  policy::MlpLayout critic;
  const float* log_std;  // [k, A]
  PackedNetwork packed_actor;
  PackedNetwork packed_critic;
};

// Fills the samples of one episode, a few steps at a time; episodes are independent.
class EpisodeBuilder {
 public:
  EpisodeBuilder(const BatchSource& source, const Networks& networks, std::size_t index,
                 std::size_t begin, TrainingBatch& batch)
      : source_(source),
        networks_(networks),
        episode_(source.episodes[index]),
        earlier_(index < source.earlier),
        task_(policy::TaskOf(source.config, episode_.number)),
        schedule_(policy::HeadSchedule::OfTraining(source.config, episode_.number)),
        begin_(begin),
        batch_(batch),
        input_(PackedNetwork::kRows, std::size_t(networks.shape.critic_input())),
        of_actor_(networks.actor, PackedNetwork::kRows),
        of_critic_(networks.critic, PackedNetwork::kRows) {}

  void Build() {
    const auto at = std::ptrdiff_t(begin_);
    std::copy(episode_.log_prob.begin(), episode_.log_prob.end(),
              batch_.behaviour_log_prob.begin() + at);
    std::copy(episode_.head.begin(), episode_.head.end(), batch_.head.begin() + at);
    for (std::int32_t t = 0; t <= length(); t += std::int32_t(PackedNetwork::kRows)) {
      BuildSteps(t, std::min(std::int32_t(PackedNetwork::kRows), length() + 1 - t));
    }
    BuildAdvantages();
  }

 private:
  [[nodiscard]] std::int32_t length() const { return episode_.length(); }

  // Of steps t .. t + count - 1, of which the last may be the final observation.
  void BuildSteps(std::int32_t t, std::int32_t count) {
    const auto actions = std::size_t(networks_.shape.action);
    WriteInputs(t, count);
    const auto rows = std::size_t(count);
    const std::vector<HeadRun> runs = Runs(t, rows);
    networks_.packed_critic.Forward(input_, of_critic_, 0, rows,
                                    policy::ValueRuns(runs, networks_.shape));
    // Without overlap the proximal policy is the behaviour policy, and the actors' own
    // log-probabilities serve; with it, the current actor's are computed.
    const bool lagging = source_.config.collection().overlap() > 0 || earlier_;
    if (lagging) networks_.packed_actor.Forward(input_, of_actor_, 0, rows, runs);
    for (std::size_t i = 0; i < rows; ++i) {
      const std::size_t step = std::size_t(t) + i;
      for (std::size_t part = 0; part < values_.size(); ++part) {
        values_[part].push_back(of_critic_.output.row(i)[part]);
      }
      if (step == std::size_t(length())) return;
      const std::size_t sample = begin_ + step;
      std::copy_n(input_.row(i), networks_.shape.critic_input(), batch_.input.row(sample));
      std::copy_n(episode_.action.data() + step * actions, actions, batch_.action.row(sample));
      batch_.proximal_log_prob[sample] =
          lagging ? ProximalLogProb(step, of_actor_.output.row(i)) : episode_.log_prob[step];
      batch_.behaviour_weight[sample] =
          lagging ? Weight(step, batch_.proximal_log_prob[sample]) : 1;
    }
  }

  void WriteInputs(std::int32_t t, std::int32_t count) {
    const policy::NetworkShape& shape = networks_.shape;
    const policy::Normaliser normaliser{
        source_.behaviour.observation_mean.data(), source_.behaviour.observation_inv_std.data(),
        static_cast<float>(source_.config.policy().observation_clip())};
    for (std::int32_t i = 0; i < count; ++i) {
      policy::WriteInput(
          shape, normaliser,
          episode_.observation.data() + std::size_t(t + i) * std::size_t(shape.observation), task_,
          t + i, source_.config.environment().horizon(), input_.row(std::size_t(i)));
      if (shape.critic_time) {
        input_.row(std::size_t(i))[shape.input()] =
            policy::Phase(t + i, source_.config.environment().horizon());
      }
    }
  }

  // The final observation's goes to the head that values it.
  [[nodiscard]] std::vector<HeadRun> Runs(std::int32_t t, std::size_t count) const {
    std::vector<HeadRun> runs;
    for (std::size_t i = 0; i < count; ++i) {
      policy::AddRow(schedule_.ValueHeadAt(t + std::int32_t(i)), i, runs);
    }
    return runs;
  }

  [[nodiscard]] float ProximalLogProb(std::size_t step, const float* mean) const {
    const auto actions = std::size_t(networks_.shape.action);
    const float* log_std = networks_.log_std + std::size_t(episode_.head[step]) * actions;
    const auto inv_std = policy::InverseStd(log_std, networks_.shape.action);
    return policy::GaussianLogProb(episode_.action.data() + step * actions, mean, inv_std.data(),
                                   log_std, networks_.shape.action);
  }

  [[nodiscard]] float Weight(std::size_t step, float proximal_log_prob) const {
    const float weight = numbers::Exp(proximal_log_prob - episode_.log_prob[step]);
    return earlier_ ? std::min(weight, kLargestWeight) : weight;
  }

  void BuildAdvantages() {
    std::vector<std::vector<float>> rewards = RewardParts(episode_, source_.config);
    for (std::size_t part = 0; part < rewards.size(); ++part) BuildAdvantages(part, rewards[part]);
  }

  void BuildAdvantages(std::size_t part, std::vector<float>& rewards) {
    const PpoConfig& ppo = source_.config.ppo();
    std::vector<float>& values = values_[part];
    const bool counts =
        algorithm::FinalStateCounts(episode_, source_.config.environment(), ppo.time_limit_value());
    const float final_value = counts ? values.back() : 0;
    values.pop_back();
    const float scale = source_.reward_scale[task_ * values_.size() + part];
    for (float& reward : rewards) reward /= scale;
    const GaeResult gae =
        ComputeGae(rewards, values, final_value, {ppo.discount(), ppo.gae_lambda()});
    const auto at = std::ptrdiff_t(begin_);
    ValuedReward& of = batch_.rewards[part];
    std::copy(values.begin(), values.end(), of.value.begin() + at);
    std::copy(gae.advantage.begin(), gae.advantage.end(), of.advantage.begin() + at);
    std::copy(gae.target.begin(), gae.target.end(), of.target.begin() + at);
  }

  const BatchSource& source_;
  const Networks& networks_;
  const Episode& episode_;
  bool earlier_;  // of a batch before
  std::size_t task_;
  policy::HeadSchedule schedule_;
  std::size_t begin_;  // its first sample
  TrainingBatch& batch_;
  kernels::Matrix input_;  // of the steps in work, as both networks have them
  policy::Activations of_actor_;
  policy::Activations of_critic_;
  std::vector<std::vector<float>> values_{std::size_t(networks_.shape.values)};  // of length + 1
};

double Variance(const std::vector<double>& values) {
  double mean = 0;
  for (const double value : values) mean += value;
  mean /= static_cast<double>(values.size());
  double variance = 0;
  for (const double value : values) variance += (value - mean) * (value - mean);
  return variance / static_cast<double>(values.size());
}

double ExplainedVariance(const std::vector<float>& target, const std::vector<float>& value) {
  std::vector<double> residual(target.size());
  for (std::size_t i = 0; i < target.size(); ++i) residual[i] = double{target[i]} - value[i];
  const double total = Variance({target.begin(), target.end()});
  return total > 0 ? 1 - Variance(residual) / total : 0;
}

float InverseRms(const std::vector<float>& values) {
  double squares = 0;
  for (const float value : values) squares += double{value} * value;
  return float(1 / (std::sqrt(squares / double(values.size())) + 1e-8));
}

std::vector<float> TotalAdvantage(const std::vector<ValuedReward>& rewards, double success_weight) {
  std::vector<float> total = rewards[0].advantage;
  if (rewards.size() == 1) return total;
  const float of_official = InverseRms(total);
  const auto of_success = float(success_weight);
  for (std::size_t i = 0; i < total.size(); ++i) {
    total[i] = total[i] * of_official + of_success * rewards[1].advantage[i];
  }
  return total;
}

}  // namespace

std::vector<std::vector<float>> RewardParts(const Episode& episode, const RunConfig& config) {
  if (policy::ShapeOf(config).values == 1) {
    return {algorithm::LearningReward(episode, config.environment())};
  }
  std::vector<float> success(episode.flags.size());
  std::transform(episode.flags.begin(), episode.flags.end(), success.begin(),
                 [](std::uint8_t flags) { return (flags & kStepSuccess) != 0 ? 1.0F : 0.0F; });
  return {episode.reward, success};
}

TrainingBatch BuildBatch(const BatchSource& source, network::WorkerTeam& team) {
  const std::vector<std::size_t> begins = BeginsOf(source.episodes);
  const std::size_t size = begins.back();
  TrainingBatch batch;
  const Networks networks(source);
  batch.input.Resize(size, std::size_t(networks.shape.critic_input()));
  batch.action.Resize(size, std::size_t(networks.shape.action));
  for (auto* values :
       {&batch.behaviour_log_prob, &batch.proximal_log_prob, &batch.behaviour_weight}) {
    values->resize(size);
  }
  batch.rewards.resize(std::size_t(networks.shape.values));
  for (ValuedReward& of : batch.rewards) {
    for (auto* values : {&of.value, &of.advantage, &of.target}) values->resize(size);
  }
  batch.head.resize(size);
  team.Run(source.episodes.size(), [&](std::size_t index) {
    EpisodeBuilder(source, networks, index, begins[index], batch).Build();
  });
  batch.advantage = TotalAdvantage(batch.rewards, source.config.ppo().success_weight());
  batch.explained_variance = ExplainedVariance(batch.rewards[0].target, batch.rewards[0].value);
  return batch;
}

}  // namespace metronome::ppo
