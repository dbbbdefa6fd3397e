#include "learner/ppo/training_batch.h"

#include <algorithm>
#include <cmath>

#include "common/policy/gaussian.h"
#include "common/policy/head_schedule.h"
#include "common/policy/network_input.h"
#include "learner/ppo/gae.h"
#include "learner/ppo/learning_reward.h"
#include "learner/ppo/mlp.h"

namespace metronome {
namespace {

// Columns 0..T of an episode by head, in time order; a head may come again. Column T goes to the
// head of the last step.
std::vector<HeadRun> EpisodeRuns(const HeadSchedule& schedule) {
  std::vector<HeadRun> runs;
  for (std::int32_t t = 0; t <= schedule.horizon(); ++t) {
    const std::int32_t head = schedule.ValueHeadAt(t);
    if (runs.empty() || runs.back().head != head) runs.push_back({head, t, 0});
    ++runs.back().count;
  }
  return runs;
}

class Builder {
 public:
  Builder(const BatchSource& source, TrainingBatch& batch)
      : source_(source),
        batch_(batch),
        shape_(ShapeOf(source.config)),
        horizon_(static_cast<std::size_t>(source.config.environment().horizon())) {}

  // Fills the samples of one episode; episodes are independent.
  void Fill(std::size_t index) const {
    const Episode& episode = source_.episodes[index];
    const std::size_t begin = index * horizon_;
    const Eigen::MatrixXf input = Input(episode);
    batch_.input.middleCols(Eigen::Index(begin), Eigen::Index(horizon_)) =
        input.leftCols(Eigen::Index(horizon_));
    batch_.action.middleCols(Eigen::Index(begin), Eigen::Index(horizon_)) =
        Eigen::Map<const Eigen::MatrixXf>(episode.action.data(), kActionSize,
                                          Eigen::Index(horizon_));
    std::copy(episode.log_prob.begin(), episode.log_prob.end(),
              batch_.behaviour_log_prob.begin() + std::ptrdiff_t(begin));
    std::copy(episode.head.begin(), episode.head.end(),
              batch_.head.begin() + std::ptrdiff_t(begin));
    const std::vector<HeadRun> runs =
        EpisodeRuns({source_.config, TrainingEpisode(source_.config, episode.number)});
    FillAdvantages(episode, input, runs, begin);
    FillProximal(episode, input, runs, begin);
  }

 private:
  Eigen::MatrixXf Input(const Episode& episode) const {
    Eigen::MatrixXf input(shape_.input(), Eigen::Index(horizon_ + 1));
    const auto clip = static_cast<float>(source_.config.policy().observation_clip());
    const auto horizon = static_cast<std::int32_t>(horizon_);
    for (std::int32_t t = 0; t <= horizon; ++t) {
      WriteInput(shape_, episode.observation.data() + std::size_t(t) * kObservationSize,
                 source_.behaviour.observation_mean.data(),
                 source_.behaviour.observation_inv_std.data(), clip, t, horizon,
                 input.col(t).data());
    }
    return input;
  }

  void FillAdvantages(const Episode& episode, const Eigen::MatrixXf& input,
                      const std::vector<HeadRun>& runs, std::size_t begin) const {
    Mlp critic(CriticLayout(shape_));
    const float* parameters = source_.parameters + ActorLayout(shape_).size;
    const Eigen::MatrixXf& value = critic.Forward(parameters, input, ValueRuns(runs, shape_));
    std::vector<float> values(value.data(), value.data() + horizon_);
    std::vector<float> rewards = LearningReward(episode, source_.config.ppo());
    for (float& reward : rewards) reward /= source_.reward_scale;
    // No last state is absorbing: the check of episodes refuses kStepTerminated.
    const PpoConfig& ppo = source_.config.ppo();
    const float final_value =
        ppo.time_limit_value() == BOOTSTRAP ? value(0, Eigen::Index(horizon_)) : 0.0F;
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
    Mlp actor(ActorLayout(shape_));
    const Eigen::MatrixXf& mean = actor.Forward(source_.parameters, input, runs);
    for (std::size_t t = 0; t < horizon_; ++t) {
      const float* log_std =
          source_.parameters + actor.layout().log_std + std::size_t(episode.head[t]) * kActionSize;
      std::array<float, kActionSize> std{};
      for (int i = 0; i < kActionSize; ++i) std[i] = std::exp(log_std[i]);
      proximal[t] = GaussianLogProb(episode.action.data() + t * kActionSize,
                                    mean.col(Eigen::Index(t)).data(), std.data(), log_std);
    }
  }

  const BatchSource& source_;
  TrainingBatch& batch_;
  NetworkShape shape_;
  std::size_t horizon_;
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
  const auto horizon = static_cast<std::size_t>(source.config.environment().horizon());
  const std::size_t size = source.episodes.size() * horizon;
  TrainingBatch batch;
  batch.input.resize(ShapeOf(source.config).input(), Eigen::Index(size));
  batch.action.resize(kActionSize, Eigen::Index(size));
  for (auto* values : {&batch.behaviour_log_prob, &batch.proximal_log_prob, &batch.value,
                       &batch.advantage, &batch.target}) {
    values->resize(size);
  }
  batch.head.resize(size);
  const Builder builder(source, batch);
  team.Run(source.episodes.size(), [&](std::size_t index) { builder.Fill(index); });
  batch.explained_variance = ExplainedVariance(batch.target, batch.value);
  return batch;
}

}  // namespace metronome
