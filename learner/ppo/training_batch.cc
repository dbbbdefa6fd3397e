#include "learner/ppo/training_batch.h"

#include <algorithm>

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

// The value of the time after the last step, if `value` is that of the final observation. An
// episode that was cut short would have gone on: its end says nothing of what comes.
float FinalValue(const Episode& episode, const RunConfig& config, float value) {
  if ((episode.flags.back() & kStepTerminated) != 0) return 0;
  if (episode.length() < config.environment().horizon()) return value;
  return config.ppo().time_limit_value() == BOOTSTRAP ? value : 0;
}

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
    const bool lagging = source_.config.collection().overlap() > 0;
    if (lagging) networks_.packed_actor.Forward(input_, of_actor_, 0, rows, runs);
    for (std::size_t i = 0; i < rows; ++i) {
      const std::size_t step = std::size_t(t) + i;
      values_.push_back(of_critic_.output.row(i)[0]);
      if (step == std::size_t(length())) return;
      const std::size_t sample = begin_ + step;
      std::copy_n(input_.row(i), networks_.shape.critic_input(), batch_.input.row(sample));
      std::copy_n(episode_.action.data() + step * actions, actions, batch_.action.row(sample));
      batch_.proximal_log_prob[sample] =
          lagging ? ProximalLogProb(step, of_actor_.output.row(i)) : episode_.log_prob[step];
      batch_.behaviour_weight[sample] =
          lagging ? numbers::Exp(batch_.proximal_log_prob[sample] - episode_.log_prob[step]) : 1;
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

  void BuildAdvantages() {
    const PpoConfig& ppo = source_.config.ppo();
    const float final_value = FinalValue(episode_, source_.config, values_.back());
    values_.pop_back();
    std::vector<float> rewards = algorithm::LearningReward(episode_, source_.config.environment());
    for (float& reward : rewards) reward /= source_.reward_scale[task_];
    const GaeResult gae =
        ComputeGae(rewards, values_, final_value, {ppo.discount(), ppo.gae_lambda()});
    const auto at = std::ptrdiff_t(begin_);
    std::copy(values_.begin(), values_.end(), batch_.value.begin() + at);
    std::copy(gae.advantage.begin(), gae.advantage.end(), batch_.advantage.begin() + at);
    std::copy(gae.target.begin(), gae.target.end(), batch_.target.begin() + at);
  }

  const BatchSource& source_;
  const Networks& networks_;
  const Episode& episode_;
  std::size_t task_;
  policy::HeadSchedule schedule_;
  std::size_t begin_;  // its first sample
  TrainingBatch& batch_;
  kernels::Matrix input_;  // of the steps in work, as both networks have them
  policy::Activations of_actor_;
  policy::Activations of_critic_;
  std::vector<float> values_;  // [length + 1]
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

}  // namespace

TrainingBatch BuildBatch(const BatchSource& source, network::WorkerTeam& team) {
  const std::vector<std::size_t> begins = BeginsOf(source.episodes);
  const std::size_t size = begins.back();
  TrainingBatch batch;
  const Networks networks(source);
  batch.input.Resize(size, std::size_t(networks.shape.critic_input()));
  batch.action.Resize(size, std::size_t(networks.shape.action));
  for (auto* values : {&batch.behaviour_log_prob, &batch.proximal_log_prob, &batch.behaviour_weight,
                       &batch.value, &batch.advantage, &batch.target}) {
    values->resize(size);
  }
  batch.head.resize(size);
  team.Run(source.episodes.size(), [&](std::size_t index) {
    EpisodeBuilder(source, networks, index, begins[index], batch).Build();
  });
  batch.explained_variance = ExplainedVariance(batch.target, batch.value);
  return batch;
}

}  // namespace metronome::ppo
