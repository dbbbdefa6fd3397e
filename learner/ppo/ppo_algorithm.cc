#include "learner/ppo/ppo_algorithm.h"

#include "common/process/cpu_times.h"
#include "learner/algorithm/episode_checker.h"
#include "learner/ppo/ppo_report.h"
#include "learner/ppo/ppo_state.h"
#include "learner/ppo/trainer.h"

namespace metronome {
namespace {

class PpoAlgorithm final : public Algorithm {
 public:
  PpoAlgorithm(const RunConfig& config, const TrainState& state,
               const AlgorithmResources& resources)
      : config_(config),
        trainer_(config, DecodePpoState(state, config), resources.threads),
        checker_(config, resources.check_key) {}

  [[nodiscard]] const RunCounters& counters() const override { return trainer_.state(); }
  UpdateReport Update(const std::vector<Episode>& batch) override {
    const CpuTimer timer(CpuUse::kUpdate);  // the team's other threads count for themselves
    PpoReport report = trainer_.Update(batch);
    report.metrics = PpoMetrics(report);
    return report;
  }
  [[nodiscard]] TrainState State() const override {
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
  [[nodiscard]] std::vector<Metric> Metrics() const override {
    return PpoMetrics(EmptyPpoReport(std::size_t(config_.policy().heads())));
  }

 private:
  RunConfig config_;
  Trainer trainer_;
  mutable EpisodeChecker checker_;
};

class PpoFactory final : public AlgorithmFactory {
 public:
  [[nodiscard]] TrainState InitialState(const RunConfig& config,
                                        const TrainState* source) const override {
    PpoState state = Trainer::InitialState(config);
    if (source != nullptr) {
      const PpoState other = DecodePpoState(*source, config);
      state.parameters = other.parameters;
      state.observation = other.observation;
    }
    return EncodePpoState(state, config);
  }
  [[nodiscard]] std::unique_ptr<Algorithm> Make(
      const RunConfig& config, const TrainState& state,
      const AlgorithmResources& resources) const override {
    return std::make_unique<PpoAlgorithm>(config, state, resources);
  }
};

}  // namespace

std::shared_ptr<const AlgorithmFactory> MakePpoFactory() { return std::make_shared<PpoFactory>(); }

}  // namespace metronome
