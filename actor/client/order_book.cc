#include "actor/client/order_book.h"

#include <algorithm>
#include <utility>

namespace metronome::client {
namespace {

// An order is for the newest weights or, with overlap 1, for those before: collection.overlap is 0
// or 1, and the learner keeps two versions on the wire.
constexpr std::uint64_t kMostVersionsBehind = 1;

}  // namespace

template <class Predicate>
void OrderBook::Drop(Predicate is_dropped) {
  std::erase_if(orders_, [&](const EpisodeOrder& order) {
    if (!is_dropped(order)) return false;
    held_numbers_ -= order.numbers.size();
    return true;
  });
}

void OrderBook::Obey(std::uint64_t incarnation) {
  const auto before = std::exchange(incarnation_, incarnation);
  Drop([&](const EpisodeOrder& order) { return order.incarnation == before || IsPast(order); });
}

void OrderBook::ObeyNobody() {
  incarnation_.reset();
  orders_.clear();
  held_numbers_ = 0;
}

bool OrderBook::IsPast(const EpisodeOrder& order) const {
  if (order.incarnation != incarnation_) return incarnation_ && order.incarnation < *incarnation_;
  // The last arrival, not the highest version: one snapshot from an outsider does not last.
  const auto newest = std::find_if(
      snapshots_.rbegin(), snapshots_.rend(),
      [&](const SnapshotPointer& snapshot) { return snapshot->incarnation == order.incarnation; });
  return newest != snapshots_.rend() && (*newest)->version > order.weights_version &&
         (*newest)->version - order.weights_version > kMostVersionsBehind;
}

void OrderBook::Add(PolicySnapshot snapshot) {
  if (snapshots_.size() >= kMaxSnapshots) snapshots_.pop_front();
  snapshots_.push_back(std::make_shared<const PolicySnapshot>(std::move(snapshot)));
  Drop([this](const EpisodeOrder& order) { return IsPast(order); });
}

bool OrderBook::Add(const EpisodeOrder& order) {
  if (order.numbers.empty() || IsPast(order)) return true;
  if (held_numbers_ + order.numbers.size() > kMaxHeldNumbers) return false;
  held_numbers_ += order.numbers.size();
  orders_.push_back(order);
  return true;
}

OrderBook::SnapshotPointer OrderBook::Find(const EpisodeOrder& order) const {
  const auto found =
      std::find_if(snapshots_.rbegin(), snapshots_.rend(), [&](const SnapshotPointer& snapshot) {
        return snapshot->incarnation == order.incarnation &&
               snapshot->version == order.weights_version;
      });
  return found == snapshots_.rend() ? nullptr : *found;
}

std::vector<EpisodeTask> OrderBook::TakeReady() {
  std::vector<EpisodeTask> tasks;
  std::erase_if(orders_, [&](const EpisodeOrder& order) {
    if (order.incarnation != incarnation_) return false;
    const SnapshotPointer snapshot = Find(order);
    if (snapshot == nullptr) return false;
    for (const std::uint64_t number : order.numbers) tasks.push_back({snapshot, number});
    held_numbers_ -= order.numbers.size();
    return true;
  });
  return tasks;
}

}  // namespace metronome::client
