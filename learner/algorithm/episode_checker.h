#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>

#include "common/messages/episode.h"
#include "common/messages/messages.h"
#include "common/policy/policy.h"
#include "common/process/cpu_times.h"
#include "common/schema/config.pb.h"
#include "learner/algorithm/episode_check.h"

namespace metronome::algorithm {

/// CheckEpisode for episodes of several versions in turn (overlap), thousands of each. Not
/// thread-safe.
class EpisodeChecker {
 public:
  /// @param config  resolved. @param key  see CheckEpisode.
  EpisodeChecker(RunConfig config, std::uint64_t key) : config_(std::move(config)), key_(key) {}

  std::optional<std::string> Check(const Episode& episode, const PolicySnapshot& snapshot) {
    const process::CpuTimer timer(process::CpuUse::kCheck);
    return CheckEpisode(episode, PolicyOf(snapshot), config_, key_);
  }

 private:
  policy::Policy& PolicyOf(const PolicySnapshot& snapshot) {
    const auto known = std::find_if(
        policies_.begin(), policies_.end(),
        [&](const policy::Policy& policy) { return policy.version() == snapshot.version; });
    if (known != policies_.end()) return *known;
    if (policies_.size() == 2) policies_.pop_front();
    return policies_.emplace_back(config_, snapshot);
  }

  RunConfig config_;
  std::uint64_t key_;
  std::deque<policy::Policy> policies_;  // of the latest versions checked
};

}  // namespace metronome::algorithm
