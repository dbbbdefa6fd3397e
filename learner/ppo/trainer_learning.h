#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <utility>

#include "common/policy/snapshot.h"
#include "common/process/cpu_times.h"
#include "learner/learning/learning.h"
#include "learner/ppo/episode_check.h"
#include "learner/ppo/trainer.h"

namespace metronome {

/// The real thing behind the coordinator's seam: multi-head PPO and the check of episodes.
class TrainerLearning final : public Learning {
 public:
  /// @param check_key  see CheckEpisode.
  TrainerLearning(const RunConfig& config, TrainState state, int threads, std::uint64_t check_key)
      : config_(config), check_key_(check_key), trainer_(config, std::move(state), threads) {}

  [[nodiscard]] const TrainState& state() const override { return trainer_.state(); }
  UpdateReport Update(const std::vector<Episode>& batch) override {
    const CpuTimer timer(CpuUse::kUpdate);  // the team's other threads count for themselves
    return trainer_.Update(batch);
  }
  [[nodiscard]] PolicySnapshot Snapshot(const TrainState& state) const override {
    return SnapshotOf(state, config_);
  }
  [[nodiscard]] PolicySnapshot PreviousSnapshot(const TrainState& state) const override {
    return PreviousSnapshotOf(state, config_);
  }
  [[nodiscard]] std::optional<std::string> Check(const Episode& episode,
                                                 const PolicySnapshot& snapshot) const override {
    const CpuTimer timer(CpuUse::kCheck);
    return CheckEpisode(episode, PolicyOf(snapshot), config_, check_key_);
  }

 private:
  /// Episodes of two versions may come in turn (overlap), thousands of each.
  Policy& PolicyOf(const PolicySnapshot& snapshot) const {
    const auto known = std::find_if(policies_.begin(), policies_.end(), [&](const Policy& policy) {
      return policy.version() == snapshot.version;
    });
    if (known != policies_.end()) return *known;
    if (policies_.size() == 2) policies_.pop_front();
    return policies_.emplace_back(config_, snapshot);
  }

  RunConfig config_;
  std::uint64_t check_key_;
  Trainer trainer_;
  mutable std::deque<Policy> policies_;  // of the latest versions checked
};

}  // namespace metronome
