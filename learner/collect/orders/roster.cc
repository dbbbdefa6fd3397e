#include "learner/collect/orders/roster.h"

#include <algorithm>
#include <functional>
#include <iterator>

namespace metronome::collect::orders {
namespace {

constexpr std::ptrdiff_t kGivenUpKept = 64;  // of an actor

using Orders = std::vector<Roster::Order>;

Orders::iterator Find(Orders* orders, std::uint64_t number) {
  return std::find_if(orders->begin(), orders->end(),
                      [&](const Roster::Order& order) { return order.number == number; });
}

}  // namespace

void Roster::Join(std::uint64_t actor_id, const std::string& host, std::uint32_t slots) {
  const auto [at, is_new] = actors_.try_emplace(actor_id);
  Actor& actor = at->second;
  if (!is_new) slots_ -= actor.slots;
  actor.host = host;
  actor.slots = std::max<std::uint32_t>(slots, 1);
  slots_ += actor.slots;
}

std::vector<std::uint64_t> Roster::Leave(std::uint64_t actor_id) {
  std::vector<std::uint64_t> numbers;
  const auto actor = actors_.find(actor_id);
  if (actor == actors_.end()) return numbers;
  for (const Order& order : actor->second.orders) numbers.push_back(order.number);
  slots_ -= actor->second.slots;
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

std::map<std::uint64_t, std::vector<std::uint64_t>> Roster::GiveUp(
    const std::function<bool(const Order&)>& is_lost) {
  std::map<std::uint64_t, std::vector<std::uint64_t>> numbers;
  const auto is_it = std::cref(is_lost);  // algorithms copy
  for (auto& [id, actor] : actors_) {
    if (std::none_of(actor.orders.begin(), actor.orders.end(), is_it)) continue;
    Orders& kept = actor.given_up;
    for (const Order& order : actor.orders) {
      if (!is_lost(order)) continue;
      numbers[id].push_back(order.number);
      kept.push_back(order);
    }
    std::erase_if(actor.orders, is_it);
    if (std::ssize(kept) > kGivenUpKept) kept.erase(kept.begin(), kept.end() - kGivenUpKept);
  }
  return numbers;
}

std::uint64_t Roster::idle() const {
  std::uint64_t idle = 0;
  for (const auto& [id, actor] : actors_) {
    idle += actor.slots - std::min<std::uint64_t>(actor.slots, actor.orders.size());
  }
  return idle;
}

std::optional<std::uint64_t> Roster::LeastLoaded(
    std::uint32_t orders_per_slot,
    const std::function<std::size_t(const Actors::value_type&)>& room) const {
  const Actors::value_type* best = nullptr;
  for (const auto& candidate : actors_) {
    const Actor& actor = candidate.second;
    const std::size_t orders = actor.orders.size();
    if (orders >= std::size_t{actor.slots} * orders_per_slot) continue;
    if (best != nullptr &&
        orders * best->second.slots >= best->second.orders.size() * actor.slots) {
      continue;
    }
    if (orders < room(candidate)) best = &candidate;  // asked last: it may be costly
  }
  return best == nullptr ? std::nullopt : std::optional(best->first);
}

}  // namespace metronome::collect::orders
