#include "learner/ppo/trainer.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "common/numbers/all_finite.h"
#include "common/numbers/elementary.h"
#include "common/numbers/random.h"
#include "common/policy/snapshot.h"
#include "common/policy/task_of.h"
#include "learner/algorithm/algorithm.h"
#include "learner/network/running_statistics.h"
#include "learner/ppo/initialise.h"
#include "learner/ppo/minibatch_step.h"
#include "learner/ppo/training_batch.h"

namespace metronome::ppo {
namespace {

// Running sums of everything that PpoReport averages.
class ReportSums {
 public:
  ReportSums(std::size_t heads, KlEstimate estimate) : estimate_(estimate), heads_(heads) {}

  void BeginEpoch() { epoch_kl_ = epoch_samples_ = 0; }

  void Add(const MinibatchSums& sums, std::size_t samples) {
    last_kl_ = 0;
    samples_ += double(samples);
    epoch_samples_ += double(samples);
    policy_loss_ += sums.policy_loss;
    value_loss_ += sums.value_loss;
    entropy_ += sums.entropy;
    gradient_norm_ += sums.gradient_norm;
    ++minibatches_;
    for (std::size_t i = 0; i < heads_.size(); ++i) {
      heads_[i].samples += sums.heads[i].samples;
      heads_[i].kl += sums.heads[i].kl;
      heads_[i].clipped += sums.heads[i].clipped;
      last_kl_ += sums.heads[i].kl / double(samples);
      epoch_kl_ += sums.heads[i].kl;
    }
  }

  /// Mean of old minus new log-probability over the last minibatch, or over the epoch so far.
  [[nodiscard]] double kl() const {
    return estimate_ == KL_ESTIMATE_EPOCH ? epoch_kl_ / epoch_samples_ : last_kl_;
  }

  void Fill(PpoReport& report) const {
    report.policy_loss = policy_loss_ / samples_;
    report.value_loss = value_loss_ / samples_;
    report.entropy = entropy_ / samples_;
    report.gradient_norm = gradient_norm_ / minibatches_;
    report.kl = kl();
    double clipped = 0;
    for (const HeadSums& head : heads_) {
      report.head_kl.push_back(head.samples > 0 ? head.kl / head.samples : 0);
      report.head_clip_share.push_back(head.samples > 0 ? head.clipped / head.samples : 0);
      clipped += head.clipped;
    }
    report.clip_share = clipped / samples_;
  }

 private:
  KlEstimate estimate_;
  std::vector<HeadSums> heads_;
  double samples_ = 0;
  double minibatches_ = 0;
  double policy_loss_ = 0;
  double value_loss_ = 0;
  double entropy_ = 0;
  double gradient_norm_ = 0;
  double last_kl_ = 0;
  double epoch_kl_ = 0;  // sum
  double epoch_samples_ = 0;
};

void FillHeadSpread(const RunConfig& config, const std::vector<float>& parameters,
                    PpoReport& report) {
  const policy::NetworkShape shape = policy::ShapeOf(config);
  constexpr double kEntropyOfUnit = 1.4189385332046727;  // of a standard normal: (1 + ln 2 pi) / 2
  const float* log_std = parameters.data() + policy::ActorLayout(shape).log_std;
  for (std::int32_t head = 0; head < shape.heads; ++head) {
    double std = 0;
    double entropy = 0;
    for (std::int32_t i = 0; i < shape.action; ++i) {
      const double value = log_std[head * shape.action + i];
      std += numbers::Exp(value) / shape.action;
      entropy += value + kEntropyOfUnit;
    }
    report.head_std.push_back(std);
    report.head_entropy.push_back(entropy);
  }
}

}  // namespace

struct Trainer::Impl {
  Impl(const RunConfig& run_config, PpoState initial, int threads)
      : config(run_config), state(std::move(initial)), team(threads), step(config, team) {}

  [[nodiscard]] std::size_t actor_size() const {
    return policy::ActorLayout(policy::ShapeOf(config)).size;
  }

  [[nodiscard]] PolicySnapshot Behaviour() const {
    const bool lagging = config.collection().overlap() > 0 && state.version > 0;
    return lagging ? PreviousSnapshotOf(state, config) : SnapshotOf(state, config);
  }

  // Discounted returns of the batch enter the reward's scale before it is used: the scale is the
  // learner's alone, no actor has acted on it.
  void MergeRewards(const std::vector<Episode>& batch, PpoState& next) const {
    for (policy::RunningStatistics& of_task : next.reward_return) {
      network::Decay(of_task, config.ppo().reward_scale_decay());
    }
    std::vector<float> discounted;  // [T, parts of the reward]
    for (const Episode& episode : batch) {
      const std::vector<std::vector<float>> parts = RewardParts(episode, config);
      std::vector<double> sums(parts.size(), 0);
      discounted.clear();
      for (std::size_t t = 0; t < episode.reward.size(); ++t) {
        for (std::size_t part = 0; part < parts.size(); ++part) {
          sums[part] = config.ppo().discount() * sums[part] + parts[part][t];
          discounted.push_back(float(sums[part]));
        }
      }
      network::Merge(next.reward_return[policy::TaskOf(config, episode.number)], discounted.data(),
                     episode.reward.size(), parts.size(), parts.size());
    }
  }

  /// By what the rewards are divided, [tasks, parts of the reward].
  [[nodiscard]] std::vector<float> RewardScales(const PpoState& next) const {
    std::vector<float> scales;
    for (const policy::RunningStatistics& of_task : next.reward_return) {
      for (std::size_t part = 0; part < of_task.mean.size(); ++part) {
        const double deviation = network::StandardDeviation(of_task, part);
        scales.push_back(
            config.ppo().normalise_reward() ? float(std::sqrt(deviation * deviation + 1e-8)) : 1);
      }
    }
    return scales;
  }

  // Of the first part, mean over tasks.
  [[nodiscard]] double MeanScale(const std::vector<float>& scales) const {
    const std::size_t tasks = policy::TaskCount(config);
    double sum = 0;
    for (std::size_t task = 0; task < tasks; ++task) sum += scales[task * scales.size() / tasks];
    return sum / double(tasks);
  }

  [[nodiscard]] StepSettings Settings() const {
    const PpoConfig& ppo = config.ppo();
    const double left = std::max(0.0, 1 - double(state.steps) / double(config.total_steps()));
    StepSettings settings;
    settings.learning_rate = ppo.learning_rate() * std::max(ppo.learning_rate_floor(), left);
    const double last = ppo.entropy_coefficient_final();
    settings.entropy_coefficient = last + (ppo.entropy_coefficient() - last) * left;
    if (ppo.min_std() > 0) settings.min_log_std = numbers::Log(ppo.min_std());
    if (ppo.std_decay() > 0) {
      const double to_go = std::max(0.0, 1 - (1 - left) / ppo.std_decay());
      const double way = std::max(0.0, config.policy().initial_log_std() - settings.min_log_std);
      settings.max_log_std = settings.min_log_std + way * to_go;
    }
    return settings;
  }

  // The epochs; returns how many were made.
  std::int32_t Learn(const TrainingBatch& batch, const StepSettings& settings,
                     OptimiserState& optimiser, ReportSums& sums) {
    step.Begin(optimiser);
    const auto minibatch = std::size_t(config.ppo().minibatch());
    for (std::int32_t epoch = 0; epoch < config.ppo().epochs(); ++epoch) {
      sums.BeginEpoch();
      const std::vector<std::uint32_t> permutation = numbers::Permutation(
          std::uint32_t(batch.size()),
          {numbers::RandomPurpose::kShuffle, config.seed(), state.version, std::uint64_t(epoch)});
      for (std::size_t begin = 0; begin < permutation.size(); begin += minibatch) {
        const std::size_t end = std::min(begin + minibatch, permutation.size());
        const std::vector<std::uint32_t> samples(permutation.begin() + std::ptrdiff_t(begin),
                                                 permutation.begin() + std::ptrdiff_t(end));
        sums.Add(step.Run(batch, samples, settings, optimiser), samples.size());
      }
      const double kl_stop = config.ppo().kl_stop();
      if (kl_stop > 0 && sums.kl() > kl_stop) return epoch + 1;
    }
    return config.ppo().epochs();
  }

  // Everything of the next state but the parameters: counters and statistics.
  void Advance(const std::vector<Episode>& batch, PpoState& next) const {
    if (config.collection().overlap() > 0) {
      next.previous_actor.assign(state.parameters.begin(),
                                 state.parameters.begin() + std::ptrdiff_t(actor_size()));
      next.previous_observation = state.observation;
    }
    const auto observations = std::size_t(policy::ShapeOf(config).observation);
    for (const Episode& episode : batch) {
      network::Merge(next.observation[policy::TaskOf(config, episode.number)],
                     episode.observation.data(), std::size_t(episode.length()), observations,
                     observations);
    }
    static_cast<checkpoint::RunCounters&>(next) = algorithm::CountersAfter(state, batch);
  }

  // What the next update learns from besides its own batch, of all that this one learnt from.
  [[nodiscard]] std::vector<Episode> Latest(std::vector<Episode> all) const {
    const auto kept = std::ptrdiff_t(config.ppo().earlier_batches()) *
                      std::ptrdiff_t(config.collection().episodes_per_update());
    const auto over = std::ptrdiff_t(all.size()) - kept;
    if (over > 0) all.erase(all.begin(), all.begin() + over);
    return all;
  }

  RunConfig config;
  PpoState state;
  network::WorkerTeam team;
  MinibatchStep step;
};

Trainer::Trainer(const RunConfig& config, PpoState state, int threads) {
  const std::size_t expected = policy::ParameterCount(policy::ShapeOf(config));
  if (state.parameters.size() != expected || state.adam_m.size() != expected ||
      state.adam_v.size() != expected) {
    throw std::invalid_argument("the state holds " + std::to_string(state.parameters.size()) +
                                " parameters, the configuration's network has " +
                                std::to_string(expected));
  }
  const std::size_t shared =
      config.ppo().shared_heads() ? network::SharedHeads(policy::ShapeOf(config)).size() : 0;
  if (state.shared.m.size() != shared || state.shared.v.size() != shared) {
    throw std::invalid_argument("the state holds " + std::to_string(state.shared.m.size()) +
                                " moments of what heads share, the configuration asks for " +
                                std::to_string(shared));
  }
  impl_ = std::make_unique<Impl>(config, std::move(state), threads);
}

Trainer::~Trainer() = default;

PpoState Trainer::InitialState(const RunConfig& config) {
  PpoState state;
  state.parameters =
      InitialParameters(policy::ShapeOf(config), config.policy().initial_log_std(), config.seed());
  state.adam_m.assign(state.parameters.size(), 0.0F);
  state.adam_v.assign(state.parameters.size(), 0.0F);
  if (config.ppo().shared_heads()) {
    const network::SharedHeads heads(policy::ShapeOf(config));
    heads.MakeEqual(state.parameters);
    state.shared = {std::vector<float>(heads.size(), 0.0F), std::vector<float>(heads.size(), 0.0F)};
  }
  for (auto* statistics : {&state.observation, &state.reward_return, &state.previous_observation}) {
    statistics->resize(policy::TaskCount(config));
  }
  return state;
}

const PpoState& Trainer::state() const { return impl_->state; }

PpoReport Trainer::Update(const std::vector<Episode>& episodes) {
  Impl& impl = *impl_;
  PpoState next = impl.state;
  impl.MergeRewards(episodes, next);
  PpoReport report;
  const std::vector<float> scales = impl.RewardScales(next);
  report.reward_scale = impl.MeanScale(scales);
  const PolicySnapshot behaviour = impl.Behaviour();
  std::vector<Episode> all = impl.state.earlier;
  all.insert(all.end(), episodes.begin(), episodes.end());
  const TrainingBatch batch = BuildBatch({impl.config, all, impl.state.earlier.size(), behaviour,
                                          impl.state.parameters.data(), scales},
                                         impl.team);
  const StepSettings settings = impl.Settings();
  OptimiserState optimiser{std::move(next.parameters), std::move(next.adam_m),
                           std::move(next.adam_v), next.adam_steps, std::move(next.shared)};
  ReportSums sums(std::size_t(policy::ShapeOf(impl.config).heads), impl.config.ppo().kl_estimate());
  report.epochs = impl.Learn(batch, settings, optimiser, sums);
  if (!numbers::AllFinite(optimiser.parameters))
    throw algorithm::NonFiniteUpdate("a parameter is not finite");
  next.parameters = std::move(optimiser.parameters);
  next.adam_m = std::move(optimiser.adam_m);
  next.adam_v = std::move(optimiser.adam_v);
  next.adam_steps = optimiser.adam_steps;
  next.shared = std::move(optimiser.shared);
  impl.Advance(episodes, next);
  next.earlier = impl.Latest(std::move(all));
  // Finite weights may still give actions that are not: no actor would play another episode.
  if (const auto defect = policy::SnapshotDefect(SnapshotOf(next, impl.config), impl.config)) {
    throw algorithm::NonFiniteUpdate("no actor can act with the new policy: " + *defect);
  }
  report.lag = impl.state.version - behaviour.version;
  report.learning_rate = settings.learning_rate;
  report.explained_variance = batch.explained_variance;
  sums.Fill(report);
  FillHeadSpread(impl.config, next.parameters, report);
  static_cast<algorithm::UpdateReport&>(report) = algorithm::ReportOf(impl.config, next, episodes);
  impl.state = std::move(next);
  return report;
}

}  // namespace metronome::ppo
