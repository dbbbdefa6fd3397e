#include "common/policy/head_schedule.h"

#include <stdexcept>
#include <string>
#include <utility>

#include "common/policy/network.h"
#include "common/policy/task_of.h"

namespace metronome::policy {

numbers::EpisodeKey TrainingEpisode(const RunConfig& config, std::uint64_t number) {
  return {numbers::RandomPurpose::kTrain, config.seed(), number};
}

HeadSchedule::HeadSchedule(const RunConfig& config, std::size_t task)
    : task_(task),
      heads_(config.policy().heads()),
      all_heads_(ShapeOf(config).heads),
      first_(all_heads_ == heads_ ? 0 : static_cast<std::int32_t>(task) * heads_),
      horizon_(config.environment().horizon()),
      interleaved_(config.policy().schedule() == SCHEDULE_INTERLEAVED) {
  if (task >= TaskCount(config)) {
    throw std::out_of_range("no task " + std::to_string(task) + ": the run has " +
                            std::to_string(TaskCount(config)));
  }
  if (heads_ < 1 || heads_ > horizon_) {
    throw std::invalid_argument("heads = " + std::to_string(heads_) +
                                " must be at least 1 and at most the horizon of " +
                                std::to_string(horizon_) + " steps");
  }
}

HeadSchedule HeadSchedule::OfTraining(const RunConfig& config, std::uint64_t number) {
  return {config, TrainingEpisode(config, number), TaskOf(config, number)};
}

HeadSchedule::HeadSchedule(const RunConfig& config, const numbers::EpisodeKey& episode,
                           std::size_t task)
    : HeadSchedule(config, task) {
  if (config.policy().schedule() == SCHEDULE_SHUFFLED) {
    order_ = numbers::Permutation(static_cast<std::uint32_t>(heads_),
                                  {numbers::RandomPurpose::kHeadPermutation, episode.seed,
                                   episode.number, static_cast<std::uint64_t>(episode.purpose)});
  }
}

HeadSchedule::HeadSchedule(const RunConfig& config, std::vector<std::uint32_t> order,
                           std::size_t task)
    : HeadSchedule(config, task) {
  if (interleaved_) {
    throw std::invalid_argument("interleaved heads have no blocks whose order could differ");
  }
  if (order.size() != static_cast<std::size_t>(heads_)) {
    throw std::invalid_argument(std::to_string(order.size()) + " heads for the policy's " +
                                std::to_string(heads_) + " blocks of time");
  }
  for (const std::uint32_t head : order) {
    if (head < static_cast<std::uint32_t>(heads_)) continue;
    throw std::invalid_argument("no head " + std::to_string(head) + ": the policy has 0 to " +
                                std::to_string(heads_ - 1));
  }
  order_ = std::move(order);
}

std::int32_t HeadSchedule::HeadAt(std::int32_t t) const {
  if (t < 0 || t >= horizon_) {
    throw std::out_of_range("step " + std::to_string(t) + " is outside an episode of " +
                            std::to_string(horizon_) + " steps");
  }
  if (interleaved_) return first_ + t % heads_;
  // Integers, 64-bit product: t * (k / T) in double gives 0 at t = 49, k = 2, T = 98.
  const auto block = static_cast<std::int32_t>(std::int64_t{t} * heads_ / horizon_);
  if (order_.empty()) return first_ + block;
  return first_ + static_cast<std::int32_t>(order_[static_cast<std::size_t>(block)]);
}

std::int32_t HeadSchedule::ValueHeadAt(std::int32_t t) const {
  return HeadAt(t == horizon_ ? t - 1 : t);
}

}  // namespace metronome::policy
