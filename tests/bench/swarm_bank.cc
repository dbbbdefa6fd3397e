#include "tests/bench/swarm_bank.h"

#include <algorithm>
#include <atomic>
#include <thread>
#include <utility>

#include "actor/metaworld/tasks/environments.h"
#include "actor/play/rollout.h"
#include "common/policy/action_noise.h"
#include "common/policy/head_schedule.h"
#include "common/policy/policy.h"
#include "learner/ppo/trainer.h"

namespace metronome::bench {

const environment::EnvironmentRegistry& Registry() {
  static const environment::EnvironmentRegistry registry(metaworld::tasks::Environments());
  return registry;
}

EpisodeBank::EpisodeBank(RunConfig config, std::uint64_t recordings, std::uint64_t prepared)
    : config_(std::move(config)),
      untrained_(ppo::SnapshotOf(ppo::Trainer::InitialState(config_), config_)) {
  const auto environment = Registry().Make(config_.environment());
  const std::atomic<bool> cancel{false};
  for (std::uint64_t number = 0; number < recordings; ++number) {
    recordings_.push_back(*play::PlayEpisode(config_, untrained_, number, *environment, cancel));
  }
  Prepare(prepared);
}

void EpisodeBank::Prepare(std::uint64_t count) {
  prepared_.resize(count);
  std::atomic<std::uint64_t> next{0};
  std::vector<std::jthread> team;
  for (unsigned i = 0; i < std::max(1U, std::thread::hardware_concurrency()); ++i) {
    team.emplace_back([&] {
      for (std::uint64_t number = next++; number < count; number = next++) {
        prepared_[number] = Decide(number, untrained_);
      }
    });
  }
}

const Episode& EpisodeBank::RecordingOf(std::uint64_t number) const {
  return recordings_[number % recordings_.size()];
}

EpisodeBank::Decisions EpisodeBank::Decide(std::uint64_t number,
                                           const PolicySnapshot& snapshot) const {
  const Episode& recording = RecordingOf(number);
  const EnvironmentSpec& spec = config_.environment().spec();
  policy::Policy policy(config_, snapshot);
  const auto schedule = policy::HeadSchedule::OfTraining(config_, number);
  policy::ActionNoise noise(config_, number);
  Decisions decisions;
  for (std::int32_t t = 0; t < recording.length(); ++t) {
    const float* observation =
        recording.observation.data() + std::size_t(t) * std::size_t(spec.observation_size());
    const policy::Policy::Decision decision = policy.Act(schedule, observation, t, noise.At(t));
    decisions.action.insert(decisions.action.end(), decision.action.begin(),
                            decision.action.begin() + spec.action_size());
    decisions.log_prob.push_back(decision.log_prob);
    decisions.head.push_back(static_cast<std::uint16_t>(decision.head));
  }
  return decisions;
}

Episode EpisodeBank::Make(std::uint64_t number, const PolicySnapshot& snapshot) const {
  Episode episode = RecordingOf(number);
  const bool is_prepared = snapshot.version == 0 && number < prepared_.size();
  Decisions decisions = is_prepared ? prepared_[number] : Decide(number, snapshot);
  episode.number = number;
  episode.weights_version = snapshot.version;
  episode.action = std::move(decisions.action);
  episode.log_prob = std::move(decisions.log_prob);
  episode.head = std::move(decisions.head);
  return episode;
}

}  // namespace metronome::bench
