#pragma once

#include <cstdint>
#include <vector>

#include "common/numbers/episode_key.h"
#include "common/schema/config.pb.h"

namespace metronome::policy {

/// Episode `number` of a training run.
numbers::EpisodeKey TrainingEpisode(const RunConfig& config, std::uint64_t number);

/// Maps the steps of one episode of T steps to the k heads: a pure function of configuration,
/// episode and step. t counts the steps already taken, 0..T-1 (the paper counts from 1).
///
/// - SCHEDULE_BLOCKS: j = floor(t * k / T), in integers. k consecutive blocks whose lengths differ
///   by at most one; head j owns block j. Source: Qureshi, Eisner, Held, arXiv:2401.01993, eq. 4.
/// - SCHEDULE_INTERLEAVED: j = t mod k. Each head has as many steps as in blocks, to one, but all
///   over the episode.
/// - SCHEDULE_SHUFFLED: the same blocks; block b belongs to head permutation[b], drawn
///   uniformly from the stream {kHeadPermutation, seed, number, purpose} of the episode's key.
///
/// An evaluation may also say itself which head gets which block.
///
/// Of several tasks, policy.heads_by says whether tasks share these heads; where they do not, the
/// heads of task i are numbers i * k to i * k + k - 1.
///
/// Immutable, hence thread-safe.
class HeadSchedule {
 public:
  /// Of training episode `number`, which says its task. Here and below:
  /// @param config  resolved. @throws std::invalid_argument unless 1 <= policy.heads <= T.
  static HeadSchedule OfTraining(const RunConfig& config, std::uint64_t number);

  /// Of any episode of the run's task number `task`. @throws as above, std::out_of_range for a task
  /// that the run does not have.
  HeadSchedule(const RunConfig& config, const numbers::EpisodeKey& episode, std::size_t task);

  /// As in blocks, but block b belongs to head order[b]. A head may have several, or none.
  /// @param order  [k], heads of the task. @throws std::invalid_argument if it has another size or
  /// a head outside
  ///               [0, k), if heads are interleaved, and as above.
  HeadSchedule(const RunConfig& config, std::vector<std::uint32_t> order, std::size_t task);

  /// @param t  environment steps taken since reset, in [0, T).
  /// @return   head in [0, heads()).
  /// @throws std::out_of_range if t is outside [0, T).
  [[nodiscard]] std::int32_t HeadAt(std::int32_t t) const;

  /// Like HeadAt, and defined at t = T too: the value after the last step belongs to the head that
  /// acted in it, which is head k-1 in blocks. Where an episode is cut before T the value belongs
  /// to the head that would have acted next.
  /// @throws std::out_of_range if t is outside [0, T].
  [[nodiscard]] std::int32_t ValueHeadAt(std::int32_t t) const;

  [[nodiscard]] std::int32_t heads() const { return all_heads_; }  // of all tasks
  [[nodiscard]] std::int32_t horizon() const { return horizon_; }
  [[nodiscard]] std::size_t task() const { return task_; }
  /// The first of the heads that act in the episode; they are policy.heads in a row.
  [[nodiscard]] std::int32_t first_head() const { return first_; }

 private:
  HeadSchedule(const RunConfig& config, std::size_t task);

  std::size_t task_;
  std::int32_t heads_;      // k
  std::int32_t all_heads_;  // of all tasks
  std::int32_t first_;      // of the task
  std::int32_t horizon_;
  bool interleaved_;
  std::vector<std::uint32_t> order_;  // of the blocks' heads; empty: block b belongs to head b
};

}  // namespace metronome::policy
