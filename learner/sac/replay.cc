#include "learner/sac/replay.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "common/policy/head_schedule.h"
#include "common/policy/network.h"
#include "common/policy/task_of.h"
#include "learner/algorithm/learning_reward.h"

namespace metronome::sac {
Replay::Replay(const RunConfig& config)
    : config_(config),
      of_head_(std::size_t(policy::ShapeOf(config).heads)),
      of_success_(of_head_.size()),
      by_reward_(policy::TaskCount(config)) {}

void Replay::Add(Episode episode) {
  const auto length = std::size_t(episode.length());
  while (!episodes_.empty() && steps_ + length > std::size_t(config_.sac().replay_steps())) {
    ForgetOldest();
  }
  const bool success = std::any_of(episode.flags.begin(), episode.flags.end(),
                                   [](auto flags) { return (flags & kStepSuccess) != 0; });
  const auto place = std::uint32_t(forgotten_ + episodes_.size());
  for (std::size_t t = 0; t < length; ++t) {
    of_head_[episode.head[t]].push_back({place, std::int32_t(t)});
    if (success) of_success_[episode.head[t]].push_back({place, std::int32_t(t)});
  }
  steps_ += length;
  ReplayEpisode kept;
  kept.success = success;
  kept.task = policy::TaskOf(config_, episode.number);
  kept.final_head =
      policy::HeadSchedule::OfTraining(config_, episode.number).ValueHeadAt(std::int32_t(length));
  kept.bootstraps =
      algorithm::FinalStateCounts(episode, config_.environment(), config_.sac().time_limit_value());
  episode.reward = algorithm::LearningReward(episode, config_.environment());
  kept.total_reward = std::accumulate(episode.reward.begin(), episode.reward.end(), 0.0);
  Ranking& ranking = by_reward_[kept.task];
  const Ranking::value_type ranked{-kept.total_reward, place};
  ranking.insert(std::lower_bound(ranking.begin(), ranking.end(), ranked), ranked);
  kept.episode = std::move(episode);
  episodes_.push_back(std::move(kept));
}

void Replay::ForgetOldest() {
  const Episode& oldest = episodes_.front().episode;
  Ranking& ranking = by_reward_[episodes_.front().task];
  const Ranking::value_type ranked{-episodes_.front().total_reward, std::uint32_t(forgotten_)};
  ranking.erase(std::lower_bound(ranking.begin(), ranking.end(), ranked));
  for (const std::uint16_t head : oldest.head) {
    of_head_[head].pop_front();
    if (episodes_.front().success) of_success_[head].pop_front();
  }
  steps_ -= std::size_t(oldest.length());
  episodes_.pop_front();
  ++forgotten_;
}

std::size_t Replay::StepsOf(std::int32_t head) const { return of_head_[std::size_t(head)].size(); }

std::size_t Replay::SuccessStepsOf(std::int32_t head) const {
  return of_success_[std::size_t(head)].size();
}

ReplayStep Replay::StepOf(std::int32_t head, std::size_t i) const {
  return StepAt(of_head_[std::size_t(head)][i]);
}

ReplayStep Replay::SuccessStepOf(std::int32_t head, std::size_t i) const {
  return StepAt(of_success_[std::size_t(head)][i]);
}

const ReplayEpisode& Replay::BestOf(std::size_t task, std::size_t rank) const {
  return episodes_[std::size_t(by_reward_[task][rank].second - forgotten_)];
}

ReplayStep Replay::StepAt(const Place& place) const {
  return {&episodes_[std::size_t(place.episode - forgotten_)], place.t};
}

}  // namespace metronome::sac
