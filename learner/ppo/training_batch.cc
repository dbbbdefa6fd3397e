#include "learner/ppo/training_batch.h"

#include <algorithm>
#include <cmath>

#include "common/policy/gaussian.h"
#include "common/policy/head_schedule.h"
#include "common/policy/network_input.h"
#include "common/policy/task_of.h"
#include "learner/ppo/gae.h"
#include "learner/ppo/learning_reward.h"
#include "learner/ppo/mlp.h"

namespace metronome::ppo {
namespace {

// Columns 0..L of an episode of L steps by head, in time order; a head may come again. Column L
// goes to the head that values the final observation.
std::vector<HeadRun> EpisodeRuns(const policy::HeadSchedule& schedule, std::int32_t length) {
  std::vector<HeadRun> runs;
  for (std::int32_t t = 0; t <= length; ++t) {
    const std::int32_t head = schedule.ValueHeadAt(t);
    if (runs.empty() || runs.back().head != head) runs.push_back({head, t, 0});
    ++runs.back().count;
  }
  return runs;
}

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

class Builder {
 public:
  Builder(const BatchSource& source, const std::vector<std::size_t>& begins, TrainingBatch& batch)
      : source_(source), begins_(begins), batch_(batch), shape_(policy::ShapeOf(source.config)) {}

  // Fills the samples of one episode; episodes are independent.
  void Fill(std::size_t index) const {
    const Episode& episode = source_.episodes[index];
    const std::size_t begin = begins_[index];
    const auto first = Eigen::Index(begin);
    const auto length = Eigen::Index(episode.length());
    const Eigen::MatrixXf input = Input(episode);
    batch_.input.middleCols(first, length) = input.leftCols(length);
    batch_.action.middleCols(first, length) =
        Eigen::Map<const Eigen::MatrixXf>(episode.action.data(), shape_.action, length);
    std::copy(episode.log_prob.begin(), episode.log_prob.end(),
              batch_.behaviour_log_prob.begin() + first);
    std::copy(episode.head.begin(), episode.head.end(), batch_.head.begin() + first);
    const std::vector<HeadRun> runs = EpisodeRuns(
        policy::HeadSchedule::OfTraining(source_.config, episode.number), episode.length());
    FillAdvantages(episode, input, runs, begin);
    FillProximal(episode, input, runs, begin);
  }

 private:
  Eigen::MatrixXf Input(const Episode& episode) const {
    Eigen::MatrixXf input(shape_.input(), Eigen::Index(episode.length()) + 1);
    const policy::Normaliser normaliser{
        source_.behaviour.observation_mean.data(), source_.behaviour.observation_inv_std.data(),
        static_cast<float>(source_.config.policy().observation_clip())};
    for (std::int32_t t = 0; t <= episode.length(); ++t) {
      policy::WriteInput(
          shape_, normaliser,
          episode.observation.data() + std::size_t(t) * std::size_t(shape_.observation),
          policy::TaskOf(source_.config, episode.number), t, source_.config.environment().horizon(),
          input.col(t).data());
    }
    return input;
  }

  void FillAdvantages(const Episode& episode, const Eigen::MatrixXf& input,
                      const std::vector<HeadRun>& runs, std::size_t begin) const {
    Mlp critic(policy::CriticLayout(shape_));
    const float* parameters = source_.parameters + policy::ActorLayout(shape_).size;
    const Eigen::MatrixXf& value = critic.Forward(parameters, input, ValueRuns(runs, shape_));
    std::vector<float> values(value.data(), value.data() + episode.length());
    std::vector<float> rewards = LearningReward(episode, source_.config.ppo());
    const float scale = source_.reward_scale[policy::TaskOf(source_.config, episode.number)];
    for (float& reward : rewards) reward /= scale;
    const PpoConfig& ppo = source_.config.ppo();
    const float final_value = FinalValue(episode, source_.config, value(0, episode.length()));
    const GaeResult gae =
        ComputeGae(rewards, values, final_value, {ppo.discount(), ppo.gae_lambda()});
    const auto at = std::ptrdiff_t(begin);
    std::copy(values.begin(), values.end(), batch_.value.begin() + at);
    std::copy(gae.advantage.begin(), gae.advantage.end(), batch_.advantage.begin() + at);
    std::copy(gae.target.begin(), gae.target.end(), batch_.target.begin() + at);
  }

  // Without overlap the proximal policy is the behaviour policy, and the actors' own
  // log-probabilities serve; with it, the current actor's are computed.
  void FillProximal(const Episode& episode, const Eigen::MatrixXf& input,
                    const std::vector<HeadRun>& runs, std::size_t begin) const {
    float* proximal = batch_.proximal_log_prob.data() + begin;
    if (source_.config.collection().overlap() == 0) {
      std::copy(episode.log_prob.begin(), episode.log_prob.end(), proximal);
      return;
    }
    Mlp actor(policy::ActorLayout(shape_));
    const Eigen::MatrixXf& mean = actor.Forward(source_.parameters, input, runs);
    const auto actions = std::size_t(shape_.action);
    for (std::size_t t = 0; t < std::size_t(episode.length()); ++t) {
      const float* log_std =
          source_.parameters + actor.layout().log_std + std::size_t(episode.head[t]) * actions;
      std::array<float, kMaxActionSize> std{};
      for (std::int32_t i = 0; i < shape_.action; ++i) std[i] = std::exp(log_std[i]);
      proximal[t] = policy::GaussianLogProb(episode.action.data() + t * actions,
                                            mean.col(Eigen::Index(t)).data(), std.data(), log_std,
                                            shape_.action);
    }
  }

  const BatchSource& source_;
  const std::vector<std::size_t>& begins_;
  TrainingBatch& batch_;
  policy::NetworkShape shape_;
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

TrainingBatch BuildBatch(const BatchSource& source, WorkerTeam& team) {
  const std::vector<std::size_t> begins = BeginsOf(source.episodes);
  const std::size_t size = begins.back();
  TrainingBatch batch;
  const policy::NetworkShape shape = policy::ShapeOf(source.config);
  batch.input.resize(shape.input(), Eigen::Index(size));
  batch.action.resize(shape.action, Eigen::Index(size));
  for (auto* values : {&batch.behaviour_log_prob, &batch.proximal_log_prob, &batch.value,
                       &batch.advantage, &batch.target}) {
    values->resize(size);
  }
  batch.head.resize(size);
  const Builder builder(source, begins, batch);
  team.Run(source.episodes.size(), [&](std::size_t index) { builder.Fill(index); });
  batch.explained_variance = ExplainedVariance(batch.target, batch.value);
  return batch;
}

}  // namespace metronome::ppo
