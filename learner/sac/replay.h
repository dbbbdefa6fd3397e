#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

#include "common/messages/episode.h"
#include "common/schema/config.pb.h"

namespace metronome::sac {

/// An episode as it is learnt from.
struct ReplayEpisode {
  Episode episode;  // its rewards those to learn from (algorithm::LearningReward)
  std::size_t task = 0;
  std::int32_t final_head = 0;  // that values the final observation
  bool bootstraps = false;      // whether the final observation's value is worth anything
  bool success = false;         // at any step
  double total_reward = 0;
};

/// One step of an episode.
struct ReplayStep {
  const ReplayEpisode* of = nullptr;
  std::int32_t t = 0;
};

/// The newest episodes, whole, in number order: as many as sac.replay_steps holds. Finds any step
/// of a head in constant time. Not thread-safe while it changes.
class Replay {
 public:
  /// @param config  resolved.
  explicit Replay(const RunConfig& config);

  /// Takes an episode in, and forgets the oldest ones that leave no room for it. @param episode  of
  /// a number above those before.
  void Add(Episode episode);

  [[nodiscard]] std::size_t episodes() const { return episodes_.size(); }
  [[nodiscard]] std::size_t steps() const { return steps_; }
  [[nodiscard]] const ReplayEpisode& episode(std::size_t i) const { return episodes_[i]; }

  /// Steps in which the head acted; @param i  which of them, the oldest first.
  [[nodiscard]] std::size_t StepsOf(std::int32_t head) const;
  [[nodiscard]] ReplayStep StepOf(std::int32_t head, std::size_t i) const;

  /// The same of episodes with success alone.
  [[nodiscard]] std::size_t SuccessStepsOf(std::int32_t head) const;
  [[nodiscard]] ReplayStep SuccessStepOf(std::int32_t head, std::size_t i) const;

  [[nodiscard]] std::size_t EpisodesOf(std::size_t task) const { return by_reward_[task].size(); }
  /// By what a task's episodes were rewarded in all. @param rank  0: the most, of several the
  /// oldest.
  [[nodiscard]] const ReplayEpisode& BestOf(std::size_t task, std::size_t rank) const;

 private:
  struct Place {
    std::uint32_t episode = 0;  // counted from the run's first
    std::int32_t t = 0;
  };

  using Places = std::vector<std::deque<Place>>;  // [heads in all]

  using Ranking = std::vector<std::pair<double, std::uint32_t>>;  // minus the reward, the episode

  void ForgetOldest();
  [[nodiscard]] ReplayStep StepAt(const Place& place) const;

  RunConfig config_;
  std::deque<ReplayEpisode> episodes_;
  std::uint64_t forgotten_ = 0;  // episodes
  std::size_t steps_ = 0;
  Places of_head_;
  Places of_success_;               // those of episodes with success
  std::vector<Ranking> by_reward_;  // [tasks], ascending
};

}  // namespace metronome::sac
