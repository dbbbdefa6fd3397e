#include "actor/client/assignment_book.h"

#include <algorithm>
#include <utility>

namespace metronome::client {
namespace {

// An assignment is for the newest weights or, with overlap 1, for those before: collection.overlap
// is 0 or 1, and the learner keeps two versions on the wire.
constexpr std::uint64_t kMostVersionsBehind = 1;

}  // namespace

template <class Predicate>
void AssignmentBook::Drop(Predicate is_dropped) {
  std::erase_if(assignments_, [&](const EpisodeAssignment& assignment) {
    if (!is_dropped(assignment)) return false;
    held_numbers_ -= assignment.numbers.size();
    return true;
  });
}

void AssignmentBook::Obey(std::uint64_t incarnation) {
  const auto before = std::exchange(incarnation_, incarnation);
  Drop([&](const EpisodeAssignment& assignment) {
    return assignment.incarnation == before || IsPast(assignment);
  });
}

void AssignmentBook::ObeyNobody() {
  incarnation_.reset();
  assignments_.clear();
  held_numbers_ = 0;
}

bool AssignmentBook::IsPast(const EpisodeAssignment& assignment) const {
  if (assignment.incarnation != incarnation_)
    return incarnation_ && assignment.incarnation < *incarnation_;
  // The last arrival, not the highest version: one snapshot from an outsider does not last.
  const auto newest =
      std::find_if(snapshots_.rbegin(), snapshots_.rend(), [&](const SnapshotPointer& snapshot) {
        return snapshot->incarnation == assignment.incarnation;
      });
  return newest != snapshots_.rend() && (*newest)->version > assignment.weights_version &&
         (*newest)->version - assignment.weights_version > kMostVersionsBehind;
}

void AssignmentBook::Add(PolicySnapshot snapshot) {
  if (snapshots_.size() >= kMaxSnapshots) snapshots_.pop_front();
  snapshots_.push_back(std::make_shared<const PolicySnapshot>(std::move(snapshot)));
  Drop([this](const EpisodeAssignment& assignment) { return IsPast(assignment); });
}

bool AssignmentBook::Add(const EpisodeAssignment& assignment) {
  if (assignment.numbers.empty() || IsPast(assignment)) return true;
  if (held_numbers_ + assignment.numbers.size() > kMaxHeldNumbers) return false;
  held_numbers_ += assignment.numbers.size();
  assignments_.push_back(assignment);
  return true;
}

AssignmentBook::SnapshotPointer AssignmentBook::Find(const EpisodeAssignment& assignment) const {
  const auto found =
      std::find_if(snapshots_.rbegin(), snapshots_.rend(), [&](const SnapshotPointer& snapshot) {
        return snapshot->incarnation == assignment.incarnation &&
               snapshot->version == assignment.weights_version;
      });
  return found == snapshots_.rend() ? nullptr : *found;
}

std::vector<EpisodeTask> AssignmentBook::TakeReady() {
  std::vector<EpisodeTask> tasks;
  std::erase_if(assignments_, [&](const EpisodeAssignment& assignment) {
    if (assignment.incarnation != incarnation_) return false;
    const SnapshotPointer snapshot = Find(assignment);
    if (snapshot == nullptr) return false;
    for (const std::uint64_t number : assignment.numbers) tasks.push_back({snapshot, number});
    held_numbers_ -= assignment.numbers.size();
    return true;
  });
  return tasks;
}

}  // namespace metronome::client
