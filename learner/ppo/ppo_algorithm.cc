#include "learner/ppo/ppo_algorithm.h"

#include "common/process/cpu_times.h"
#include "learner/algorithm/episode_checker.h"
#include "learner/ppo/ppo_report.h"
#include "learner/ppo/ppo_state.h"
#include "learner/ppo/trainer.h"

namespace metronome::ppo {
namespace {

class PpoAlgorithm final : public algorithm::Algorithm {
 public:
  PpoAlgorithm(const RunConfig& config, const checkpoint::TrainState& state,
               const algorithm::AlgorithmResources& resources)
      : config_(config),
        trainer_(config, DecodePpoState(state, config), resources.threads),
        checker_(config, resources.check_key) {}

  [[nodiscard]] const checkpoint::RunCounters& counters() const override {
    return trainer_.state();
  }
  algorithm::UpdateReport Update(const std::vector<Episode>& batch) override {
    const process::CpuTimer timer(
        process::CpuUse::kUpdate);  // the team's other threads count for themselves
    PpoReport report = trainer_.Update(batch);
    report.metrics = PpoMetrics(report);
    return report;
  }
  [[nodiscard]] checkpoint::TrainState State() const override {
    return EncodePpoState(trainer_.state(), config_);
  }
  [[nodiscard]] PolicySnapshot Snapshot() const override {
    return SnapshotOf(trainer_.state(), config_);
  }
  [[nodiscard]] PolicySnapshot PreviousSnapshot() const override {
    return PreviousSnapshotOf(trainer_.state(), config_);
  }
  [[nodiscard]] std::optional<std::string> Check(const Episode& episode,
                                                 const PolicySnapshot& snapshot) const override {
    return checker_.Check(episode, snapshot);
  }
  [[nodiscard]] std::vector<algorithm::Metric> Metrics() const override {
    return PpoMetrics(EmptyPpoReport(std::size_t(policy::ShapeOf(config_).heads)));
  }

 private:
  RunConfig config_;
  Trainer trainer_;
  mutable algorithm::EpisodeChecker checker_;
};

class PpoFactory final : public algorithm::AlgorithmFactory {
 public:
  [[nodiscard]] checkpoint::TrainState InitialState(
      const RunConfig& config, const checkpoint::TrainState* source) const override {
    PpoState state = Trainer::InitialState(config);
    if (source != nullptr) {
      const PpoState other = DecodePpoState(*source, config);
      state.parameters = other.parameters;
      state.observation = other.observation;
    }
    return EncodePpoState(state, config);
  }
  [[nodiscard]] std::unique_ptr<algorithm::Algorithm> Make(
      const RunConfig& config, const checkpoint::TrainState& state,
      const algorithm::AlgorithmResources& resources) const override {
    return std::make_unique<PpoAlgorithm>(config, state, resources);
  }
};

}  // namespace

std::shared_ptr<const algorithm::AlgorithmFactory> MakePpoFactory() {
  return std::make_shared<PpoFactory>();
}

}  // namespace metronome::ppo
