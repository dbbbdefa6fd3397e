#pragma once

#include <cstddef>
#include <vector>

#include "learner/ppo/worker_team.h"

namespace metronome::ppo {

/// How the shards of a minibatch are gathered: whole shards, in order, into as few to a group as
/// kMostGroups allows. A pure function of the number of shards.
struct ShardGroups {
  /// So many gradients are held at once, however large the minibatch is.
  static constexpr std::size_t kMostGroups = 64;

  std::size_t shards = 0;
  std::size_t shards_per_group = 1;

  static ShardGroups Of(std::size_t shards);
  [[nodiscard]] std::size_t count() const {
    return (shards + shards_per_group - 1) / shards_per_group;
  }
  /// Of a group: its first shard, and one past its last.
  [[nodiscard]] std::size_t begin(std::size_t group) const { return group * shards_per_group; }
  [[nodiscard]] std::size_t end(std::size_t group) const;
};

/// Holds a gradient for each group and sums them in the order of the groups: the bits of the sum
/// follow from the groups' gradients alone, whoever computed them and on how many threads. The
/// seam for learners that share a batch. Not thread-safe, but that groups may be filled side by
/// side.
class GradientReducer {
 public:
  /// @param groups      at most that many are summed.
  /// @param parameters  length of a gradient.
  GradientReducer(std::size_t groups, std::size_t parameters, WorkerTeam& team);

  /// The gradient of one group, `parameters` floats, for whoever computes it to write.
  [[nodiscard]] float* Of(std::size_t group) { return of_group_.at(group).data(); }

  /// Sums groups 0 .. groups - 1. @return the Euclidean norm of the sum.
  double Reduce(std::size_t groups);

  /// The result of Reduce, [parameters].
  [[nodiscard]] const std::vector<float>& sum() const { return sum_; }
  [[nodiscard]] std::size_t groups_held() const { return of_group_.size(); }

 private:
  std::vector<std::vector<float>> of_group_;
  std::vector<float> sum_;
  WorkerTeam& team_;
};

}  // namespace metronome::ppo
