#include "learner/algorithm/episode_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "common/numbers/all_finite.h"
#include "common/numbers/random.h"
#include "common/policy/explorer.h"
#include "common/policy/head_schedule.h"
#include "common/policy/network.h"
#include "common/policy/policy.h"
#include "common/text/number_text.h"

namespace metronome::algorithm {
namespace {

bool AllWithin(const std::vector<float>& values, float bound) {
  for (const float value : values) {
    if (!(std::abs(value) <= bound)) return false;
  }
  return true;
}

std::optional<std::string> CheckLength(std::size_t length, const EnvironmentConfig& environment) {
  const auto horizon = std::size_t(environment.horizon());
  const bool early = environment.spec().may_end_early();
  if (length == horizon || (early && length > 0 && length < horizon)) return std::nullopt;
  return "it has " + text::Counted(length, "step") + ", not " + (early ? "1 to " : "") +
         std::to_string(horizon);
}

std::optional<std::string> CheckShape(const Episode& episode,
                                      const EnvironmentConfig& environment) {
  const std::size_t length = episode.reward.size();
  if (auto reason = CheckLength(length, environment)) return reason;
  const auto observations = std::size_t(environment.spec().observation_size());
  const auto actions = std::size_t(environment.spec().action_size());
  const auto wrong = [](const char* what, std::size_t is, std::size_t want) {
    return std::string(what) + " has length " + std::to_string(is) + ", not " +
           std::to_string(want);
  };
  if (episode.observation.size() != (length + 1) * observations) {
    return wrong("observation", episode.observation.size(), (length + 1) * observations);
  }
  if (episode.action.size() != length * actions) {
    return wrong("action", episode.action.size(), length * actions);
  }
  if (episode.log_prob.size() != length) return wrong("log_prob", episode.log_prob.size(), length);
  if (episode.head.size() != length) return wrong("head", episode.head.size(), length);
  if (episode.flags.size() != length) return wrong("flags", episode.flags.size(), length);
  return std::nullopt;
}

std::optional<std::string> CheckFinite(const Episode& episode) {
  if (!numbers::AllFinite(episode.observation)) return "an observation is not finite";
  if (!numbers::AllFinite(episode.action)) return "an action is not finite";
  if (!numbers::AllFinite(episode.log_prob)) return "a log-probability is not finite";
  if (!numbers::AllFinite(episode.reward)) return "a reward is not finite";
  return std::nullopt;
}

// One absurd number would spoil a running scale for the rest of the run, or overflow a sum.
std::optional<std::string> CheckRange(const Episode& episode) {
  if (!AllWithin(episode.observation, kLargestObservation)) return "an observation is out of range";
  if (!AllWithin(episode.reward, kLargestReward)) return "a reward is out of range";
  return std::nullopt;
}

std::optional<std::string> CheckHeads(const Episode& episode,
                                      const policy::HeadSchedule& schedule) {
  for (std::int32_t t = 0; t < episode.length(); ++t) {
    const std::uint16_t head = episode.head[std::size_t(t)];
    if (head == schedule.HeadAt(t)) continue;
    return "step " + std::to_string(t) + " names head " + std::to_string(head) +
           ", the schedule gives " + std::to_string(schedule.HeadAt(t));
  }
  return std::nullopt;
}

// An episode ends at its last step, for one reason, and nowhere else.
std::optional<std::string> CheckFlags(const Episode& episode, const EnvironmentSpec& spec) {
  for (std::int32_t t = 0; t < episode.length(); ++t) {
    const std::uint8_t flags = episode.flags[std::size_t(t)];
    const int end = flags & ~kStepSuccess;
    const bool last = t + 1 == episode.length();
    const bool right =
        last ? end == kStepTruncated || (end == kStepTerminated && spec.may_end_early()) : end == 0;
    const bool success = (flags & kStepSuccess) != 0;
    if (right && (spec.has_success() || !success)) continue;
    return "step " + std::to_string(t) + " has flags " + std::to_string(flags);
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
  const policy::HeadSchedule& schedule;
  policy::Policy& policy;
  policy::Explorer explorer;
  std::size_t observation_size = std::size_t(config.environment().spec().observation_size());
  std::size_t action_size = std::size_t(config.environment().spec().action_size());

  [[nodiscard]] const float* ObservationAt(std::int32_t t) const {
    return episode.observation.data() + std::size_t(t) * observation_size;
  }
};

std::optional<std::string> CheckStep(Recomputation& of, std::int32_t t,
                                     const policy::Policy::Gaussian& gaussian) {
  const policy::Policy::Decision expected =
      of.explorer.ActAround(of.policy, of.schedule, gaussian, t);
  const double tolerance = of.config.collection().check_tolerance();
  const auto at = std::size_t(t);
  bool equal = Equal(of.episode.log_prob[at], expected.log_prob, tolerance);
  for (std::size_t i = 0; i < of.action_size; ++i) {
    equal =
        equal && Equal(of.episode.action[at * of.action_size + i], expected.action[i], tolerance);
  }
  if (equal) return std::nullopt;
  return "step " + std::to_string(t) + ": weights version " + std::to_string(of.policy.version()) +
         " gives log-probability " + std::to_string(expected.log_prob) + ", the episode says " +
         std::to_string(of.episode.log_prob[at]) + " (action or log-probability differ)";
}

std::optional<std::string> CheckEveryStep(Recomputation& of) {
  std::array<policy::Policy::Gaussian, policy::Policy::kMostStates> gaussians{};
  const std::int32_t length = of.episode.length();
  for (std::int32_t t = 0; t < length;) {
    const auto count = std::min(gaussians.size(), std::size_t(length - t));
    of.policy.Gaussians(of.schedule, of.ObservationAt(t), t, {gaussians.data(), count});
    for (std::size_t i = 0; i < count; ++i, ++t) {
      if (auto reason = CheckStep(of, t, gaussians[i])) return reason;
    }
  }
  return std::nullopt;
}

std::optional<std::string> CheckSample(Recomputation& of, std::uint64_t key) {
  for (std::int32_t t = 0; t < of.episode.length(); ++t) {
    numbers::RandomStream random(numbers::RandomPurpose::kCheck, key, of.episode.number,
                                 std::uint64_t(t));
    if (random.Uniform() >= of.config.collection().check_share()) continue;
    policy::Policy::Gaussian gaussian;
    of.policy.Gaussians(of.schedule, of.ObservationAt(t), t, {&gaussian, 1});
    if (auto reason = CheckStep(of, t, gaussian)) return reason;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> CheckEpisode(const Episode& episode, policy::Policy& policy,
                                        const RunConfig& config, std::uint64_t key) {
  if (episode.weights_version != policy.version()) {
    return "weights version " + std::to_string(episode.weights_version) + " instead of " +
           std::to_string(policy.version());
  }
  if (auto reason = CheckShape(episode, config.environment())) return reason;
  if (auto reason = CheckFinite(episode)) return reason;
  if (auto reason = CheckRange(episode)) return reason;
  const auto schedule = policy::HeadSchedule::OfTraining(config, episode.number);
  if (auto reason = CheckHeads(episode, schedule)) return reason;
  if (auto reason = CheckFlags(episode, config.environment().spec())) return reason;
  Recomputation of{episode, config, schedule, policy, policy::Explorer(config, episode.number)};
  return config.collection().check_share() >= 1 ? CheckEveryStep(of) : CheckSample(of, key);
}

}  // namespace metronome::algorithm
