#pragma once

#include <cstdint>

namespace metronome {

/// Maps an in-episode step to the policy head that acts on it: j = floor(t * k / T), in integers.
///
/// An episode of T steps is cut into k consecutive segments whose lengths differ by at most one;
/// head j owns segment j. The paper counts t from 1; here t counts the steps already taken, 0..T-1.
/// Source: Qureshi, Eisner, Held, arXiv:2401.01993, eq. 4. Immutable, hence thread-safe.
class HeadSchedule {
 public:
  /// @param heads    k.
  /// @param horizon  T, environment steps an episode.
  /// @throws std::invalid_argument unless 1 <= heads <= horizon.
  HeadSchedule(std::int32_t heads, std::int32_t horizon);

  /// @param t  environment steps taken since reset, in [0, horizon).
  /// @return   head in [0, heads), non-decreasing in t.
  /// @throws std::out_of_range if t is outside [0, horizon).
  [[nodiscard]] std::int32_t HeadAt(std::int32_t t) const;

  /// Like HeadAt, and defined at t = T too: the value after the last step belongs to the last head.
  /// @throws std::out_of_range if t is outside [0, horizon].
  [[nodiscard]] std::int32_t ValueHeadAt(std::int32_t t) const;

  [[nodiscard]] std::int32_t heads() const { return heads_; }
  [[nodiscard]] std::int32_t horizon() const { return horizon_; }

 private:
  std::int32_t heads_;
  std::int32_t horizon_;
};

}  // namespace metronome
