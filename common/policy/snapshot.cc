#include "common/policy/snapshot.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>

#include "common/policy/network.h"

namespace metronome::policy {
namespace {

// Of all numbers but log-stds. A layer sums up to 4097 products of a weight and an input, which is
// at most 1e9 (policy.observation_clip): 4e32 at most, and float32 goes to 3e38.
constexpr float kLargest = 1e20F;
// std from 1e-20 to 1e20: neither it nor (action - mean) / std leaves float32.
constexpr float kLargestLogStd = 46;

/// Names the first value that is not a number from -limit to limit; std::nullopt if there is none.
std::optional<std::string> Beyond(const char* what, const float* begin, const float* end,
                                  float limit) {
  const float* found =
      std::find_if_not(begin, end, [limit](float value) { return std::abs(value) <= limit; });
  if (found == end) return std::nullopt;
  std::ostringstream text;
  text << what << " is " << *found << ", not from " << -limit << " to " << limit;
  return text.str();
}

}  // namespace

PolicySnapshot MakeSnapshot(std::uint64_t version, const float* actor,
                            const std::vector<RunningStatistics>& observation,
                            const RunConfig& config) {
  const NetworkShape shape = ShapeOf(config);
  const auto observations = static_cast<std::size_t>(shape.observation);
  PolicySnapshot snapshot;
  snapshot.version = version;
  snapshot.parameters.assign(actor, actor + ActorLayout(shape).size);
  snapshot.observation_mean.assign(shape.statistics(), 0.0F);
  snapshot.observation_inv_std.assign(shape.statistics(), 1.0F);
  for (std::size_t task = 0; task < observation.size(); ++task) {
    const RunningStatistics& of_task = observation[task];
    if (of_task.count == 0) continue;
    for (std::size_t i = 0; i < observations; ++i) {
      const double variance = of_task.m2[i] / of_task.count;
      snapshot.observation_mean[task * observations + i] = float(of_task.mean[i]);
      snapshot.observation_inv_std[task * observations + i] =
          float(1 / std::sqrt(variance + config.policy().observation_epsilon()));
    }
  }
  return snapshot;
}

std::optional<std::string> SnapshotDefect(const PolicySnapshot& snapshot, const RunConfig& config) {
  const NetworkShape shape = ShapeOf(config);
  const MlpLayout layout = ActorLayout(shape);
  const std::vector<float>& parameters = snapshot.parameters;
  if (parameters.size() != layout.size) {
    return "it has " + std::to_string(parameters.size()) + " parameters, the run's network needs " +
           std::to_string(layout.size);
  }
  const float* log_std = parameters.data() + layout.log_std;
  const float* end = parameters.data() + parameters.size();
  if (auto beyond = Beyond("a parameter", parameters.data(), log_std, kLargest)) return beyond;
  if (auto beyond = Beyond("a log-std", log_std, end, kLargestLogStd)) return beyond;
  for (const auto* statistics : {&snapshot.observation_mean, &snapshot.observation_inv_std}) {
    if (statistics->size() != shape.statistics()) {
      return "its observation statistics are of " + std::to_string(statistics->size()) +
             " numbers, observations of all tasks of " + std::to_string(shape.statistics());
    }
    if (auto beyond = Beyond("an observation statistic", statistics->data(),
                             statistics->data() + statistics->size(), kLargest)) {
      return beyond;
    }
  }
  return std::nullopt;
}

}  // namespace metronome::policy
