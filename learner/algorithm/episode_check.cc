#include "learner/algorithm/episode_check.h"

#include <cmath>
#include <cstddef>
#include <vector>

#include "common/numbers/all_finite.h"
#include "common/numbers/random.h"
#include "common/policy/action_noise.h"
#include "common/policy/head_schedule.h"
#include "common/policy/network.h"
#include "common/policy/policy.h"

namespace metronome {
namespace {

bool AllWithin(const std::vector<float>& values, float bound) {
  for (const float value : values) {
    if (!(std::abs(value) <= bound)) return false;
  }
  return true;
}

std::optional<std::string> CheckShape(const Episode& episode, const RunConfig& config) {
  const auto horizon = std::size_t(config.environment().horizon());
  const auto wrong = [&](const char* what, std::size_t is, std::size_t want) {
    return std::string(what) + " has length " + std::to_string(is) + ", not " +
           std::to_string(want);
  };
  if (episode.reward.size() != horizon) return wrong("reward", episode.reward.size(), horizon);
  if (episode.observation.size() != (horizon + 1) * kObservationSize) {
    return wrong("observation", episode.observation.size(), (horizon + 1) * kObservationSize);
  }
  if (episode.action.size() != horizon * kActionSize) {
    return wrong("action", episode.action.size(), horizon * kActionSize);
  }
  if (episode.log_prob.size() != horizon)
    return wrong("log_prob", episode.log_prob.size(), horizon);
  if (episode.head.size() != horizon) return wrong("head", episode.head.size(), horizon);
  if (episode.flags.size() != horizon) return wrong("flags", episode.flags.size(), horizon);
  return std::nullopt;
}

std::optional<std::string> CheckFinite(const Episode& episode) {
  if (!AllFinite(episode.observation)) return "an observation is not finite";
  if (!AllFinite(episode.action)) return "an action is not finite";
  if (!AllFinite(episode.log_prob)) return "a log-probability is not finite";
  if (!AllFinite(episode.reward)) return "a reward is not finite";
  return std::nullopt;
}

// One absurd number would spoil a running scale for the rest of the run, or overflow a sum.
std::optional<std::string> CheckRange(const Episode& episode) {
  if (!AllWithin(episode.observation, kLargestObservation)) return "an observation is out of range";
  if (!AllWithin(episode.reward, kLargestReward)) return "a reward is out of range";
  return std::nullopt;
}

std::optional<std::string> CheckSchedule(const Episode& episode, const HeadSchedule& schedule) {
  for (std::int32_t t = 0; t < schedule.horizon(); ++t) {
    const auto at = std::size_t(t);
    if (episode.head[at] != schedule.HeadAt(t)) {
      return "step " + std::to_string(t) + " names head " + std::to_string(episode.head[at]) +
             ", the schedule gives " + std::to_string(schedule.HeadAt(t));
    }
    const bool last = t + 1 == schedule.horizon();
    const int flags = episode.flags[at] & ~kStepSuccess;
    if (flags != (last ? kStepTruncated : 0)) {
      return "step " + std::to_string(t) + " has flags " + std::to_string(episode.flags[at]);
    }
  }
  return std::nullopt;
}

bool Equal(float given, float expected, double tolerance) {
  return tolerance == 0 ? given == expected
                        : std::abs(double{given} - double{expected}) <= tolerance;
}

/// An episode whose shape and schedule are right, and what its steps are recomputed from.
struct Recomputation {
  const Episode& episode;
  const RunConfig& config;
  const HeadSchedule& schedule;
  Policy& policy;
  ActionNoise noise;

  [[nodiscard]] const float* ObservationAt(std::int32_t t) const {
    return episode.observation.data() + std::size_t(t) * kObservationSize;
  }
};

std::optional<std::string> CheckStep(Recomputation& of, std::int32_t t,
                                     const std::array<float, kActionSize>& mean) {
  const Policy::Decision expected = of.policy.ActAround(of.schedule, mean, t, of.noise.At(t));
  const double tolerance = of.config.collection().check_tolerance();
  const auto at = std::size_t(t);
  bool equal = Equal(of.episode.log_prob[at], expected.log_prob, tolerance);
  for (std::size_t i = 0; i < kActionSize; ++i) {
    equal = equal && Equal(of.episode.action[at * kActionSize + i], expected.action[i], tolerance);
  }
  if (equal) return std::nullopt;
  return "step " + std::to_string(t) + ": weights version " + std::to_string(of.policy.version()) +
         " gives log-probability " + std::to_string(expected.log_prob) + ", the episode says " +
         std::to_string(of.episode.log_prob[at]) + " (action or log-probability differ)";
}

std::optional<std::string> CheckEveryStep(Recomputation& of) {
  std::int32_t t = 0;
  for (; t + Policy::kStates <= of.episode.length(); t += Policy::kStates) {
    const auto means = of.policy.Means(of.schedule, of.ObservationAt(t), t);
    for (int i = 0; i < Policy::kStates; ++i) {
      if (auto reason = CheckStep(of, t + i, means[i])) return reason;
    }
  }
  for (; t < of.episode.length(); ++t) {
    const auto mean = of.policy.Mean(of.schedule, of.ObservationAt(t), t);
    if (auto reason = CheckStep(of, t, mean)) return reason;
  }
  return std::nullopt;
}

std::optional<std::string> CheckSample(Recomputation& of, std::uint64_t key) {
  for (std::int32_t t = 0; t < of.episode.length(); ++t) {
    RandomStream random(RandomPurpose::kCheck, key, of.episode.number, std::uint64_t(t));
    if (random.Uniform() >= of.config.collection().check_share()) continue;
    const auto mean = of.policy.Mean(of.schedule, of.ObservationAt(t), t);
    if (auto reason = CheckStep(of, t, mean)) return reason;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> CheckEpisode(const Episode& episode, Policy& policy,
                                        const RunConfig& config, std::uint64_t key) {
  if (episode.weights_version != policy.version()) {
    return "weights version " + std::to_string(episode.weights_version) + " instead of " +
           std::to_string(policy.version());
  }
  if (auto reason = CheckShape(episode, config)) return reason;
  if (auto reason = CheckFinite(episode)) return reason;
  if (auto reason = CheckRange(episode)) return reason;
  const HeadSchedule schedule(config, TrainingEpisode(config, episode.number));
  if (auto reason = CheckSchedule(episode, schedule)) return reason;
  Recomputation of{episode, config, schedule, policy, ActionNoise(config, episode.number)};
  return config.collection().check_share() >= 1 ? CheckEveryStep(of) : CheckSample(of, key);
}

}  // namespace metronome
