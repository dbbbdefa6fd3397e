#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/checkpoint/train_state.h"
#include "common/policy/network.h"
#include "common/process/cpu_times.h"
#include "learner/algorithm/algorithm.h"
#include "learner/algorithm/episode_checker.h"

namespace metronome::algorithm {

/// An algorithm over a trainer, which has state() and Update(batch) as Algorithm means them; the
/// functions SnapshotOf and PreviousSnapshotOf are those of the state's namespace. What else
/// differs is `Parts`:
///   static checkpoint::TrainState Encode(state, config);
///   static Report BlankReport(heads);
///   static std::vector<Metric> MetricsOf(report);
template <typename Trainer, typename Parts>
class TrainerAlgorithm final : public Algorithm {
 public:
  /// @param config  resolved. @param check_key  see CheckEpisode.
  TrainerAlgorithm(const RunConfig& config, std::unique_ptr<Trainer> trainer,
                   std::uint64_t check_key)
      : config_(config), trainer_(std::move(trainer)), checker_(config, check_key) {}

  [[nodiscard]] const checkpoint::RunCounters& counters() const override {
    return trainer_->state();
  }
  UpdateReport Update(const std::vector<Episode>& batch) override {
    const process::CpuTimer timer(
        process::CpuUse::kUpdate);  // the team's other threads count for themselves
    auto report = trainer_->Update(batch);
    report.metrics = Parts::MetricsOf(report);
    return report;
  }
  [[nodiscard]] checkpoint::TrainState State() const override {
    return Parts::Encode(trainer_->state(), config_);
  }
  [[nodiscard]] PolicySnapshot Snapshot() const override {
    return SnapshotOf(trainer_->state(), config_);
  }
  [[nodiscard]] PolicySnapshot PreviousSnapshot() const override {
    return PreviousSnapshotOf(trainer_->state(), config_);
  }
  [[nodiscard]] std::optional<std::string> Check(const Episode& episode,
                                                 const PolicySnapshot& snapshot) const override {
    return checker_.Check(episode, snapshot);
  }
  [[nodiscard]] std::vector<Metric> Metrics() const override {
    return Parts::MetricsOf(Parts::BlankReport(std::size_t(policy::ShapeOf(config_).heads)));
  }

 private:
  RunConfig config_;
  std::unique_ptr<Trainer> trainer_;
  mutable EpisodeChecker checker_;
};

}  // namespace metronome::algorithm
