#include "actor/play/rollout.h"

#include <array>
#include <chrono>
#include <cstddef>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/policy/explorer.h"
#include "common/policy/head_schedule.h"
#include "common/policy/policy.h"
#include "common/process/cpu_times.h"

namespace metronome::play {
namespace {

/// Room for the longest episode, so that no step allocates.
Episode EmptyEpisode(std::uint64_t number, std::uint64_t version, const EnvironmentConfig& config) {
  const auto horizon = std::size_t(config.horizon());
  Episode episode;
  episode.number = number;
  episode.weights_version = version;
  episode.observation.reserve((horizon + 1) * std::size_t(config.spec().observation_size()));
  episode.action.reserve(horizon * std::size_t(config.spec().action_size()));
  episode.log_prob.reserve(horizon);
  episode.reward.reserve(horizon);
  episode.head.reserve(horizon);
  episode.flags.reserve(horizon);
  return episode;
}

/// One more row of `size` numbers, to be filled.
std::span<float> NewRow(std::vector<float>& rows, std::size_t size) {
  rows.resize(rows.size() + size);
  return std::span(rows).last(size);
}

/// @param last  the horizon ends the episode here.
std::uint8_t FlagsOf(const environment::StepOutcome& step, bool last) {
  const bool truncated = !step.terminated && (step.truncated || last);
  return static_cast<std::uint8_t>((step.success ? kStepSuccess : 0) |
                                   (step.terminated ? kStepTerminated : 0) |
                                   (truncated ? kStepTruncated : 0));
}

void RequireWhole(const Episode& episode, const EnvironmentConfig& config) {
  if (config.spec().may_end_early() || episode.length() == config.horizon()) return;
  throw std::logic_error("environment " + config.task() + " ended an episode after " +
                         std::to_string(episode.length()) +
                         " steps, and its specification says that it never does so early");
}

/// Shares out an episode's CPU time in proportion to the wall-clock time between laps: CPU time
/// itself takes a system call, wall-clock time none.
class Stopwatch {
 public:
  using Clock = std::chrono::steady_clock;

  void Lap(process::CpuUse use) {
    const Clock::time_point now = Clock::now();
    laps_[static_cast<std::size_t>(use)] += now - last_;
    last_ = now;
  }

  void Count() const {
    const double share = (process::ThreadCpuSeconds() - cpu_begin_) /
                         std::chrono::duration<double>(last_ - begin_).count();
    for (std::size_t use = 0; use < laps_.size(); ++use) {
      process::CpuTimes::OfProcess().Add(process::CpuUse(use),
                                         share * std::chrono::duration<double>(laps_[use]).count());
    }
  }

 private:
  const double cpu_begin_ = process::ThreadCpuSeconds();
  const Clock::time_point begin_ = Clock::now();
  Clock::time_point last_ = begin_;
  std::array<Clock::duration, static_cast<std::size_t>(process::CpuUse::kCount)> laps_{};
};

}  // namespace

std::optional<Episode> PlayEpisode(const RunConfig& config, const PolicySnapshot& snapshot,
                                   std::uint64_t number, environment::Environment& environment,
                                   const std::atomic<bool>& cancel) {
  Stopwatch stopwatch;
  const std::int32_t horizon = config.environment().horizon();
  const auto observations = std::size_t(config.environment().spec().observation_size());
  const auto actions = std::size_t(config.environment().spec().action_size());
  policy::Policy policy(config, snapshot);
  const auto schedule = policy::HeadSchedule::OfTraining(config, number);
  policy::Explorer explorer(config, number);
  Episode episode = EmptyEpisode(number, snapshot.version, config.environment());
  stopwatch.Lap(process::CpuUse::kPolicy);
  environment::EpisodeStart start = environment::TrainingStart(config, number);
  environment.Reset(start, NewRow(episode.observation, observations));
  stopwatch.Lap(process::CpuUse::kReset);
  bool ended = false;
  for (std::int32_t t = 0; !ended; ++t) {
    if (cancel.load(std::memory_order_relaxed)) return std::nullopt;
    const float* observation = episode.observation.data() + std::size_t(t) * observations;
    const policy::Policy::Decision decision = explorer.Act(policy, schedule, observation, t);
    stopwatch.Lap(process::CpuUse::kPolicy);
    const std::span action(decision.action.data(), actions);
    const environment::StepOutcome step =
        environment.Step(action, NewRow(episode.observation, observations));
    stopwatch.Lap(process::CpuUse::kPhysics);
    ended = step.terminated || step.truncated || t + 1 == horizon;
    episode.action.insert(episode.action.end(), action.begin(), action.end());
    episode.log_prob.push_back(decision.log_prob);
    episode.reward.push_back(static_cast<float>(step.reward));
    episode.head.push_back(static_cast<std::uint16_t>(decision.head));
    episode.flags.push_back(FlagsOf(step, t + 1 == horizon));
    stopwatch.Lap(process::CpuUse::kRollout);
  }
  RequireWhole(episode, config.environment());
  stopwatch.Count();
  return episode;
}

}  // namespace metronome::play
