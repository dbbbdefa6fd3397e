#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "common/messages/messages.h"

namespace metronome::client {

/// One episode to play.
struct EpisodeTask {
  std::shared_ptr<const PolicySnapshot> snapshot;
  std::uint64_t number = 0;
};

/// Brings assignments and snapshots together, whatever order they and their learner's description
/// come in: topics are not ordered among each other. Assignments that can never be played are
/// forgotten: those of a learner older than the obeyed one, and those whose snapshot was overtaken.
/// Bounded. Not thread-safe.
class AssignmentBook {
 public:
  static constexpr std::size_t kMaxSnapshots = 8;        // the newest arrivals
  static constexpr std::size_t kMaxHeldNumbers = 16384;  // waiting for a snapshot, in all

  /// Assignments of this incarnation are given out from now on; those of the one before, and of
  /// older ones, are dropped.
  void Obey(std::uint64_t incarnation);
  /// Nobody is obeyed: all assignments are dropped.
  void ObeyNobody();

  void Add(PolicySnapshot snapshot);
  /// @return false if the book is full; the assignment is dropped and will be given again.
  bool Add(const EpisodeAssignment& assignment);

  /// Episodes that can be played, as they came in; each once.
  std::vector<EpisodeTask> TakeReady();
  /// Numbers that wait for their snapshot or their learner.
  [[nodiscard]] std::size_t held() const { return held_numbers_; }

 private:
  using SnapshotPointer = std::shared_ptr<const PolicySnapshot>;
  [[nodiscard]] SnapshotPointer Find(const EpisodeAssignment& assignment) const;
  [[nodiscard]] bool IsPast(const EpisodeAssignment& assignment) const;
  /// Drops the assignments for which `is_dropped(assignment)` holds.
  template <class Predicate>
  void Drop(Predicate is_dropped);

  std::optional<std::uint64_t> incarnation_;
  std::deque<SnapshotPointer> snapshots_;
  std::deque<EpisodeAssignment> assignments_;
  std::size_t held_numbers_ = 0;
};

}  // namespace metronome::client
