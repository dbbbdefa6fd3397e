#include "actor/order_book.h"

#include <algorithm>
#include <utility>

namespace metronome {

void OrderBook::Obey(std::uint64_t incarnation) {
  if (incarnation_) DropOrdersOf(*incarnation_);
  incarnation_ = incarnation;
}

void OrderBook::ObeyNobody() {
  incarnation_.reset();
  orders_.clear();
  held_numbers_ = 0;
}

void OrderBook::DropOrdersOf(std::uint64_t incarnation) {
  std::erase_if(orders_, [&](const EpisodeOrder& order) {
    if (order.incarnation != incarnation) return false;
    held_numbers_ -= order.numbers.size();
    return true;
  });
}

void OrderBook::Add(PolicySnapshot snapshot) {
  if (snapshots_.size() >= kMaxSnapshots) snapshots_.pop_front();
  snapshots_.push_back(std::make_shared<const PolicySnapshot>(std::move(snapshot)));
}

bool OrderBook::Add(const EpisodeOrder& order) {
  if (held_numbers_ + order.numbers.size() > kMaxHeldNumbers) return false;
  if (order.numbers.empty()) return true;
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

}  // namespace metronome
