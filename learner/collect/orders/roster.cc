#include "learner/collect/orders/roster.h"

#include <algorithm>
#include <iterator>

namespace metronome {
namespace {

constexpr std::ptrdiff_t kGivenUpKept = 64;  // of an actor

using Orders = std::vector<Roster::Order>;

Orders::iterator Find(Orders* orders, std::uint64_t number) {
  return std::find_if(orders->begin(), orders->end(),
                      [&](const Roster::Order& order) { return order.number == number; });
}

}  // namespace

void Roster::Join(std::uint64_t actor_id, const std::string& host, std::uint32_t slots) {
  Actor& actor = actors_[actor_id];
  actor.host = host;
  actor.slots = std::max<std::uint32_t>(slots, 1);
}

std::vector<std::uint64_t> Roster::Leave(std::uint64_t actor_id) {
  std::vector<std::uint64_t> numbers;
  const auto actor = actors_.find(actor_id);
  if (actor == actors_.end()) return numbers;
  for (const Order& order : actor->second.orders) numbers.push_back(order.number);
  actors_.erase(actor);
  return numbers;
}

void Roster::Give(std::uint64_t actor_id, std::uint64_t number, TimePoint now) {
  actors_.at(actor_id).orders.push_back({number, now});
}

std::optional<std::chrono::nanoseconds> Roster::Release(std::uint64_t actor_id,
                                                        std::uint64_t number, TimePoint now) {
  const auto actor = actors_.find(actor_id);
  if (actor == actors_.end()) return std::nullopt;
  Orders& orders = actor->second.orders;
  const auto order = Find(&orders, number);
  if (order == orders.end()) {
    // Given up too early: the estimate of how long an episode takes must learn from it.
    Orders& given_up = actor->second.given_up;
    const auto late = Find(&given_up, number);
    if (late == given_up.end()) return std::nullopt;
    const auto took = now - late->since;
    given_up.erase(late);
    return took;
  }
  const auto took = now - order->since;
  const auto index = static_cast<std::size_t>(order - orders.begin());
  orders.erase(order);
  const std::size_t last_slot = actor->second.slots - 1;
  if (index <= last_slot && orders.size() > last_slot) orders[last_slot].since = now;
  return took;
}

std::vector<std::uint64_t> Roster::GiveUp(std::uint64_t actor_id,
                                          const std::function<bool(const Order&)>& is_lost) {
  Actor& actor = actors_.at(actor_id);
  Orders lost;
  std::copy_if(actor.orders.begin(), actor.orders.end(), std::back_inserter(lost), is_lost);
  std::erase_if(actor.orders, is_lost);
  Orders& kept = actor.given_up;
  kept.insert(kept.end(), lost.begin(), lost.end());
  if (std::ssize(kept) > kGivenUpKept) kept.erase(kept.begin(), kept.end() - kGivenUpKept);
  std::vector<std::uint64_t> numbers;
  for (const Order& order : lost) numbers.push_back(order.number);
  return numbers;
}

std::uint64_t Roster::slots() const {
  std::uint64_t slots = 0;
  for (const auto& actor : actors_) slots += actor.second.slots;
  return slots;
}

std::uint64_t Roster::idle() const {
  std::uint64_t idle = 0;
  for (const auto& [id, actor] : actors_) {
    idle += actor.slots - std::min<std::uint64_t>(actor.slots, actor.orders.size());
  }
  return idle;
}

std::optional<std::uint64_t> Roster::LeastLoaded(
    const std::function<std::size_t(const Actors::value_type&)>& room) const {
  const Actors::value_type* best = nullptr;
  for (const auto& candidate : actors_) {
    const Actor& actor = candidate.second;
    if (actor.orders.size() >= room(candidate)) continue;
    if (best == nullptr ||
        actor.orders.size() * best->second.slots < best->second.orders.size() * actor.slots) {
      best = &candidate;
    }
  }
  return best == nullptr ? std::nullopt : std::optional(best->first);
}

}  // namespace metronome
