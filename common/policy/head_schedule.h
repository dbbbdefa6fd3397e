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
/// Immutable, hence thread-safe.
class HeadSchedule {
 public:
  /// @param config  resolved. @throws std::invalid_argument unless 1 <= policy.heads <= T.
  HeadSchedule(const RunConfig& config, const numbers::EpisodeKey& episode);

  /// As in blocks, but block b belongs to head order[b]. A head may have several, or none.
  /// @param order  [k], heads. @throws std::invalid_argument if it has another size or a head
  /// outside
  ///               [0, k), if heads are interleaved, and as above.
  HeadSchedule(const RunConfig& config, std::vector<std::uint32_t> order);

  /// @param t  environment steps taken since reset, in [0, T).
  /// @return   head in [0, k).
  /// @throws std::out_of_range if t is outside [0, T).
  [[nodiscard]] std::int32_t HeadAt(std::int32_t t) const;

  /// Like HeadAt, and defined at t = T too: the value after the last step belongs to the head that
  /// acted in it, which is head k-1 in blocks. Where an episode is cut before T the value belongs
  /// to the head that would have acted next.
  /// @throws std::out_of_range if t is outside [0, T].
  [[nodiscard]] std::int32_t ValueHeadAt(std::int32_t t) const;

  [[nodiscard]] std::int32_t heads() const { return heads_; }
  [[nodiscard]] std::int32_t horizon() const { return horizon_; }

 private:
  explicit HeadSchedule(const RunConfig& config);

  std::int32_t heads_;
  std::int32_t horizon_;
  bool interleaved_;
  std::vector<std::uint32_t> order_;  // of the blocks' heads; empty: block b belongs to head b
};

}  // namespace metronome::policy
