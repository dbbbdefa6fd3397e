/// The learner's epochs alone, on synthetic episodes: shuffling, both networks, loss, clipping and
/// Adam, as an update makes them, beside the machine's GEMM rate. One JSON line.
#include <CLI/CLI.hpp>
#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <vector>

#include "common/config/config.h"
#include "common/kernels/isa_option.h"
#include "common/numbers/random.h"
#include "common/policy/action_noise.h"
#include "common/policy/head_schedule.h"
#include "common/policy/policy.h"
#include "learner/network/worker_team.h"
#include "learner/ppo/minibatch_step.h"
#include "learner/ppo/trainer.h"
#include "learner/ppo/training_batch.h"
#include "tests/unit/support/environments.h"

namespace metronome {
namespace {

struct Options {
  int width = 128;
  int minibatch = 1000;
  int episodes = 16;
  int epochs = 10;
  int threads = 2;
  int heads = 10;
  int repeats = 5;
};

double Seconds(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

RunConfig ConfigOf(const Options& options) {
  RunConfig config;
  test::SetTask(config, "push");
  config.mutable_policy()->set_heads(options.heads);
  config.mutable_policy()->add_hidden(options.width);
  config.mutable_policy()->add_hidden(options.width);
  config.mutable_ppo()->set_minibatch(options.minibatch);
  config.mutable_ppo()->set_epochs(options.epochs);
  config.mutable_ppo()->set_kl_stop(0);
  // Plain PPO, as the peers have it.
  config.mutable_policy()->set_critic_time(false);
  config.mutable_ppo()->set_shared_heads(false);
  config.mutable_collection()->set_episodes_per_update(options.episodes);
  return config::Resolve(config);
}

/// Observations are noise, actions the policy's own, rewards noise.
Episode SyntheticEpisode(const RunConfig& config, policy::Policy& policy, std::uint64_t number) {
  Episode episode;
  episode.number = number;
  const std::int32_t horizon = config.environment().horizon();
  const auto schedule = policy::HeadSchedule::OfTraining(config, number);
  numbers::RandomStream random(numbers::RandomPurpose::kEvaluate, 1, number, 0);
  episode.observation.resize(std::size_t(horizon + 1) * test::kObservationSize);
  for (float& value : episode.observation) value = float(random.Normal());
  policy::ActionNoise noise(config, number);
  for (std::int32_t t = 0; t < horizon; ++t) {
    const policy::Policy::Decision decision =
        policy.Act(schedule, episode.observation.data() + std::size_t(t) * test::kObservationSize,
                   t, noise.At(t));
    episode.action.insert(episode.action.end(), decision.action.begin(),
                          decision.action.begin() + test::kActionSize);
    episode.log_prob.push_back(decision.log_prob);
    episode.head.push_back(std::uint16_t(decision.head));
    episode.reward.push_back(float(random.Uniform()));
    episode.flags.push_back(t + 1 == horizon ? kStepTruncated : 0);
  }
  return episode;
}

/// Floating-point operations of one sample in one epoch: forward, gradient by weights, gradient by
/// inputs (not below the first layer), two each a weight.
double OperationsPerSample(const RunConfig& config) {
  const policy::NetworkShape shape = policy::ShapeOf(config);
  double operations = 0;
  for (const policy::MlpLayout& layout :
       {policy::ActorLayout(shape), policy::CriticLayout(shape)}) {
    for (std::size_t i = 0; i < layout.hidden.size(); ++i) {
      const policy::LayerSlice& slice = layout.hidden[i];
      operations += (i == 0 ? 4.0 : 6.0) * slice.inputs * slice.outputs;
    }
    operations += 6.0 * layout.head.inputs * layout.head_outputs;
  }
  return operations;
}

/// Operations a second of Eigen's float32 product of square matrices, one a thread.
double GemmRate(int threads, int repeats) {
  constexpr Eigen::Index kSize = 1024;
  struct Job {
    Eigen::MatrixXf a = Eigen::MatrixXf::Random(kSize, kSize);
    Eigen::MatrixXf b = Eigen::MatrixXf::Random(kSize, kSize);
    Eigen::MatrixXf c = Eigen::MatrixXf::Zero(kSize, kSize);
  };
  std::vector<Job> jobs(static_cast<std::size_t>(threads));
  network::WorkerTeam team(threads);
  std::vector<double> seconds;
  for (int i = 0; i <= repeats; ++i) {
    seconds.push_back(Seconds([&] {
      team.Run(jobs.size(), [&](std::size_t j) { jobs[j].c.noalias() = jobs[j].a * jobs[j].b; });
    }));
  }
  return 2.0 * kSize * kSize * kSize * threads / Median(seconds);
}

/// All epochs from `state`, which stays as it is.
void MakeEpochs(const RunConfig& config, const ppo::TrainingBatch& batch,
                const ppo::PpoState& state, network::WorkerTeam& team) {
  ppo::MinibatchStep step(config, team);
  ppo::OptimiserState optimiser{state.parameters, state.adam_m, state.adam_v, 0, state.shared};
  step.Begin(optimiser);
  const auto minibatch = std::size_t(config.ppo().minibatch());
  for (std::int32_t epoch = 0; epoch < config.ppo().epochs(); ++epoch) {
    const std::vector<std::uint32_t> permutation = numbers::Permutation(
        std::uint32_t(batch.size()),
        {numbers::RandomPurpose::kShuffle, config.seed(), 0, std::uint64_t(epoch)});
    for (std::size_t begin = 0; begin < permutation.size(); begin += minibatch) {
      const std::size_t end = std::min(begin + minibatch, permutation.size());
      const std::vector<std::uint32_t> samples(permutation.begin() + std::ptrdiff_t(begin),
                                               permutation.begin() + std::ptrdiff_t(end));
      step.Run(batch, samples, {5e-4, 0.005}, optimiser);
    }
  }
}

void Run(const Options& options) {
  const RunConfig config = ConfigOf(options);
  const ppo::PpoState state = ppo::Trainer::InitialState(config);
  const PolicySnapshot snapshot = ppo::SnapshotOf(state, config);
  policy::Policy policy(config, snapshot);
  std::vector<Episode> episodes;
  for (int i = 0; i < options.episodes; ++i) {
    episodes.push_back(SyntheticEpisode(config, policy, std::uint64_t(i)));
  }
  const double gemm = GemmRate(options.threads, options.repeats);
  network::WorkerTeam team(options.threads);
  const ppo::TrainingBatch batch =
      ppo::BuildBatch({config, episodes, 0, snapshot, state.parameters.data(), {1.0F, 1.0F}}, team);
  std::vector<double> seconds;
  for (int i = 0; i <= options.repeats; ++i) {
    const double passed = Seconds([&] { MakeEpochs(config, batch, state, team); });
    if (i > 0) seconds.push_back(passed);  // the first one warms up
  }
  const double samples = double(options.episodes) * config.environment().horizon() * options.epochs;
  const double rate = samples / Median(seconds);
  std::printf(
      "{\"width\": %d, \"minibatch\": %d, \"threads\": %d, \"samples_per_second\": %.0f, "
      "\"update_seconds\": %.4f, \"gflops\": %.2f, \"gemm_gflops\": %.2f}\n",
      options.width, options.minibatch, options.threads, rate, Median(seconds),
      rate * OperationsPerSample(config) * 1e-9, gemm * 1e-9);
}

}  // namespace
}  // namespace metronome

int main(int argc, char** argv) {
  metronome::Options options;
  CLI::App app("The learner's epochs alone, and the machine's GEMM rate; one JSON line");
  app.add_option("--width", options.width, "of both hidden layers")->capture_default_str();
  app.add_option("--minibatch", options.minibatch)->capture_default_str();
  app.add_option("--episodes", options.episodes, "an update, of 500 steps")->capture_default_str();
  app.add_option("--epochs", options.epochs)->capture_default_str();
  app.add_option("--threads", options.threads)->capture_default_str();
  app.add_option("--heads", options.heads)->capture_default_str();
  app.add_option("--repeats", options.repeats)->capture_default_str();
  metronome::kernels::AddIsaOption(app);
  CLI11_PARSE(app, argc, argv);
  metronome::Run(options);
  return 0;
}
