#include "learner/sac/sac_algorithm.h"

#include "common/process/cpu_times.h"
#include "learner/algorithm/episode_checker.h"
#include "learner/sac/sac_report.h"
#include "learner/sac/sac_state.h"
#include "learner/sac/trainer.h"

namespace metronome::sac {
namespace {

class SacAlgorithm final : public algorithm::Algorithm {
 public:
  SacAlgorithm(const RunConfig& config, const checkpoint::TrainState& state,
               const algorithm::AlgorithmResources& resources)
      : config_(config),
        trainer_(config, DecodeSacState(state, config), resources.replay, resources.threads),
        checker_(config, resources.check_key) {}

  [[nodiscard]] const checkpoint::RunCounters& counters() const override {
    return trainer_.state();
  }
  algorithm::UpdateReport Update(const std::vector<Episode>& batch) override {
    const process::CpuTimer timer(
        process::CpuUse::kUpdate);  // the team's other threads count for themselves
    SacReport report = trainer_.Update(batch);
    report.metrics = SacMetrics(report);
    return report;
  }
  [[nodiscard]] checkpoint::TrainState State() const override {
    return EncodeSacState(trainer_.state(), config_);
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
    return SacMetrics(EmptySacReport(std::size_t(policy::ShapeOf(config_).heads)));
  }

 private:
  RunConfig config_;
  Trainer trainer_;
  mutable algorithm::EpisodeChecker checker_;
};

class SacFactory final : public algorithm::AlgorithmFactory {
 public:
  [[nodiscard]] checkpoint::TrainState InitialState(
      const RunConfig& config, const checkpoint::TrainState* source) const override {
    SacState state = InitialSacState(config);
    if (source != nullptr) {
      const SacState other = DecodeSacState(*source, config);
      state.optimiser.actor = other.optimiser.actor;
      state.optimiser.critics = other.optimiser.critics;
      state.optimiser.targets = other.optimiser.targets;
      state.observation = other.observation;
    }
    return EncodeSacState(state, config);
  }
  [[nodiscard]] std::unique_ptr<algorithm::Algorithm> Make(
      const RunConfig& config, const checkpoint::TrainState& state,
      const algorithm::AlgorithmResources& resources) const override {
    return std::make_unique<SacAlgorithm>(config, state, resources);
  }
};

}  // namespace

std::shared_ptr<const algorithm::AlgorithmFactory> MakeSacFactory() {
  return std::make_shared<SacFactory>();
}

}  // namespace metronome::sac
