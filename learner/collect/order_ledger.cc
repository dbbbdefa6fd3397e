#include "learner/collect/order_ledger.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "common/messages/messages.h"
#include "learner/collect/doubling.h"

namespace metronome {
namespace {

constexpr std::size_t kGivenUpKept = 64;     // of an actor
constexpr std::uint32_t kMostDoublings = 6;  // of the patience with an order

template <class Value>
bool Contains(const std::vector<Value>& values, const Value& value) {
  return std::find(values.begin(), values.end(), value) != values.end();
}

}  // namespace

OrderLedger::OrderLedger(const OrderRules& rules)
    : rules_(rules), version_(rules.first_version), next_batch_(rules.first_version) {
  if (rules.episodes_per_update == 0 || rules.orders_per_slot == 0 || rules.updates_total == 0) {
    throw std::invalid_argument("order rules: a count is 0");
  }
  if (rules.first_version > rules.updates_total) {
    throw std::invalid_argument("order rules: the first version lies behind the last update");
  }
  OpenBatches();
}

void OrderLedger::OpenBatches() {
  const std::uint64_t end = std::min(rules_.updates_total, version_ + rules_.overlap + 1);
  for (; next_batch_ < end; ++next_batch_) {
    const std::uint64_t first = next_batch_ * rules_.episodes_per_update;
    for (std::uint64_t i = 0; i < rules_.episodes_per_update; ++i) {
      numbers_.emplace(first + i, Number{});
      open_.insert(first + i);
    }
  }
}

void OrderLedger::Join(std::uint64_t actor_id, const std::string& name, std::uint32_t slots,
                       TimePoint now, TimePoint trusted_from) {
  if (IsRefused(actor_id)) return;
  CountIdle(now);
  const auto [at, is_new] = actors_.try_emplace(actor_id);
  if (is_new && counts_.HasManyActors()) ForgetCountsOfLost();
  Actor& actor = at->second;
  actor.name = name;
  host_of_[actor_id] = HostOfName(name);
  actor.slots = std::max<std::uint32_t>(slots, 1);
  actor.trusted_from = trusted_from;
}

// Each start of an actor has another name.
void OrderLedger::ForgetCountsOfLost() {
  std::set<std::string> present;
  for (const auto& actor : actors_) present.insert(actor.second.name);
  counts_.KeepActors(present);
}

std::size_t OrderLedger::Lose(std::uint64_t actor_id, TimePoint now) {
  CountIdle(now);
  return Drop(actor_id);
}

void OrderLedger::Refuse(std::uint64_t actor_id, TimePoint now) {
  CountIdle(now);
  Drop(actor_id);
  refused_.insert(actor_id);
}

std::size_t OrderLedger::Drop(std::uint64_t actor_id) {
  const auto actor = actors_.find(actor_id);
  if (actor == actors_.end()) return 0;
  const std::size_t orders = actor->second.out.size();
  for (const Outstanding& out : actor->second.out) TakeBack(out.number, actor_id);
  actors_.erase(actor);
  return orders;
}

// A number that nobody plays any more is open again, unless it is here already.
void OrderLedger::TakeBack(std::uint64_t number, std::uint64_t actor_id) {
  const auto entry = numbers_.find(number);
  if (entry == numbers_.end()) return;
  std::erase(entry->second.holders, actor_id);
  if (entry->second.state != Number::State::kOut || !entry->second.holders.empty()) return;
  entry->second.state = Number::State::kOpen;
  open_.insert(number);
}

void OrderLedger::Publish(std::uint64_t version, TimePoint now) {
  if (version != version_ + 1 || !IsComplete(version_)) {
    throw std::logic_error("weights version " + std::to_string(version) + " does not follow");
  }
  CountIdle(now);
  numbers_.erase(numbers_.begin(), numbers_.lower_bound(version * rules_.episodes_per_update));
  accepted_of_batch_.erase(version_);
  ForgetHosts();
  version_ = version;
  OpenBatches();
}

// Of those who cannot bring anything any more: a lost actor may, what it was asked for.
void OrderLedger::ForgetHosts() {
  std::set<std::uint64_t> asked;
  for (const auto& entry : numbers_) {
    asked.insert(entry.second.asked.begin(), entry.second.asked.end());
  }
  std::erase_if(host_of_, [&](const auto& actor) {
    return !actors_.contains(actor.first) && !asked.contains(actor.first);
  });
}

OrderLedger::Standing OrderLedger::StandingOf(std::uint64_t number, std::uint64_t actor_id) const {
  if (number < version_ * rules_.episodes_per_update) return Standing::kDuplicate;
  const auto entry = numbers_.find(number);
  if (entry == numbers_.end()) return Standing::kNotOrdered;
  if (entry->second.state == Number::State::kAccepted) return Standing::kDuplicate;
  if (entry->second.state == Number::State::kArrived) return Standing::kNotOrdered;
  if (Contains(entry->second.heard, actor_id)) return Standing::kDuplicate;
  return Contains(entry->second.asked, actor_id) ? Standing::kWanted : Standing::kNotOrdered;
}

std::uint64_t OrderLedger::BehaviourVersion(std::uint64_t number) const {
  const std::uint64_t batch = number / rules_.episodes_per_update;
  return batch - std::min(batch, rules_.overlap);
}

void OrderLedger::Arrive(std::uint64_t number, std::uint64_t actor_id, TimePoint now) {
  if (StandingOf(number, actor_id) != Standing::kWanted) {
    throw std::logic_error("episode " + std::to_string(number) + " is not wanted");
  }
  CountIdle(now);
  open_.erase(number);
  numbers_.at(number).state = Number::State::kArrived;
  const auto actor = actors_.find(actor_id);
  if (actor != actors_.end()) Release(*actor, number, now);
}

// The actor has brought `number`: the order that waited longest begins.
void OrderLedger::Release(ActorMap::value_type& actor, std::uint64_t number, TimePoint now) {
  actor.second.silences = 0;
  actor.second.rests_until = {};
  std::vector<Outstanding>& out = actor.second.out;
  const auto is_it = [&](const Outstanding& o) { return o.number == number; };
  const auto at = std::find_if(out.begin(), out.end(), is_it);
  if (at == out.end()) {
    // Given up too early: the estimate of how long an episode takes must learn from it.
    std::vector<Outstanding>& given_up = actor.second.given_up;
    const auto late = std::find_if(given_up.begin(), given_up.end(), is_it);
    if (late == given_up.end()) return;
    durations_.Add(now - late->since);
    given_up.erase(late);
    return;
  }
  durations_.Add(now - at->since);
  const auto index = static_cast<std::size_t>(at - out.begin());
  out.erase(at);
  const std::size_t last_slot = actor.second.slots - 1;
  if (index <= last_slot && out.size() > last_slot) out[last_slot].since = now;
  TakeBack(number, actor.first);
}

void OrderLedger::Accept(std::uint64_t number, std::uint64_t actor_id) {
  Number& entry = numbers_.at(number);
  if (entry.state != Number::State::kArrived) {
    throw std::logic_error("episode " + std::to_string(number) + " has not arrived");
  }
  Hear(entry, actor_id);
  AcceptHeard(number, actor_id, entry.hosts);
}

void OrderLedger::Hear(Number& number, std::uint64_t actor_id) {
  number.heard.push_back(actor_id);
  const std::string& host = HostOf(actor_id);
  if (!Contains(number.hosts, host)) number.hosts.push_back(host);
  const auto actor = actors_.find(actor_id);
  if (actor != actors_.end()) actor->second.bad_in_a_row = 0;
}

const std::string& OrderLedger::HostOf(std::uint64_t actor_id) const {
  static const std::string unknown = "unknown host";
  const auto host = host_of_.find(actor_id);
  return host == host_of_.end() ? unknown : host->second;
}

void OrderLedger::AcceptHeard(std::uint64_t number, std::uint64_t actor_id,
                              std::vector<std::string> hosts) {
  Number& entry = numbers_.at(number);
  entry.state = Number::State::kAccepted;
  entry.hosts = std::move(hosts);
  open_.erase(number);
  ++accepted_of_batch_[number / rules_.episodes_per_update];
  const auto actor = actors_.find(actor_id);
  counts_.CountAccepted(actor == actors_.end() ? "lost actors" : actor->second.name);
}

void OrderLedger::AskAnother(std::uint64_t number, std::uint64_t actor_id, bool disputed) {
  Number& entry = numbers_.at(number);
  Hear(entry, actor_id);
  entry.disputed = disputed;
  entry.state = Number::State::kOut;
  TakeBack(number, actor_id);
}

bool OrderLedger::HasOther(std::uint64_t number) const {
  const Number& entry = numbers_.at(number);
  return std::any_of(actors_.begin(), actors_.end(), [&](const auto& actor) {
    return actor.second.silences == 0 && MayPlay(entry, actor);
  });
}

std::vector<std::uint64_t> OrderLedger::OnTheWordOf(const std::string& host) const {
  std::vector<std::uint64_t> numbers;
  for (const auto& [number, entry] : numbers_) {
    const bool alone = entry.hosts.size() == 1 && entry.hosts.front() == host;
    if (entry.state == Number::State::kAccepted && alone) numbers.push_back(number);
  }
  return numbers;
}

void OrderLedger::Reopen(std::uint64_t number) {
  Number& entry = numbers_.at(number);
  if (entry.state == Number::State::kAccepted) {
    --accepted_of_batch_.at(number / rules_.episodes_per_update);
  }
  entry.heard.clear();
  entry.hosts.clear();
  entry.disputed = false;
  entry.state = entry.holders.empty() ? Number::State::kOpen : Number::State::kOut;
  if (entry.holders.empty()) open_.insert(number);
}

bool OrderLedger::Reject(std::uint64_t number, std::uint64_t actor_id, const std::string& reason) {
  Number& entry = numbers_.at(number);
  if (entry.state != Number::State::kArrived) {
    throw std::logic_error("episode " + std::to_string(number) + " has not arrived");
  }
  entry.state = Number::State::kOut;
  TakeBack(number, actor_id);
  Discard(actor_id, reason);
  const auto actor = actors_.find(actor_id);
  return actor != actors_.end() && ++actor->second.bad_in_a_row > rules_.bad_answers_allowed;
}

void OrderLedger::Discard(std::uint64_t actor_id, const std::string& reason) {
  const auto actor = actors_.find(actor_id);
  counts_.CountRejected(actor == actors_.end() ? "strangers" : actor->second.name, reason);
}

void OrderLedger::ArriveAgain(std::uint64_t number, std::uint64_t actor_id, bool differs,
                              TimePoint now) {
  CountIdle(now);
  const auto actor = actors_.find(actor_id);
  counts_.CountDuplicate(actor == actors_.end() ? "lost actors" : actor->second.name, differs);
  if (actor != actors_.end()) Release(*actor, number, now);
}

std::vector<Assignment> OrderLedger::Plan(TimePoint now) {
  CountIdle(now);
  std::vector<Assignment> plan;
  GiveUpLost(now);
  PlanOpen(now, plan);
  PlanLate(now, plan);
  return plan;
}

// An order that nothing came of for very long (a sample dropped on the way, an actor that hangs)
// does not block its slot for ever. But its actor may merely be slow, so it rests before it is
// asked again: else a machine that is suddenly slower would be buried under repeated orders.
void OrderLedger::GiveUpLost(TimePoint now) {
  for (auto& [id, actor] : actors_) {
    const auto lost = [&](const Outstanding& out) { return now - out.since >= LostAfter(out); };
    const std::size_t before = actor.given_up.size();
    std::copy_if(actor.out.begin(), actor.out.end(), std::back_inserter(actor.given_up), lost);
    if (actor.given_up.size() == before) continue;
    std::erase_if(actor.out, lost);
    for (std::size_t i = before; i < actor.given_up.size(); ++i) {
      TakeBack(actor.given_up[i].number, id);
    }
    if (actor.given_up.size() > kGivenUpKept) {
      actor.given_up.erase(actor.given_up.begin(), actor.given_up.end() - kGivenUpKept);
    }
    actor.rests_until = now + Doubling(++actor.silences, rules_.first_rest, rules_.longest_rest);
  }
}

std::chrono::nanoseconds OrderLedger::LostAfter(const Outstanding& out) const {
  const auto number = numbers_.find(out.number);
  const std::uint32_t tries = number == numbers_.end() ? 1 : number->second.tries;
  const std::uint32_t doublings = std::min(std::max(tries, 1U) - 1, kMostDoublings);
  return Scaled(rules_.lost_factor * double(1U << doublings));
}

void OrderLedger::PlanOpen(TimePoint now, std::vector<Assignment>& plan) {
  // Who gave up an order, or comes and goes, is asked only when nobody else is there.
  const bool any_reliable = std::any_of(actors_.begin(), actors_.end(), [now](const auto& actor) {
    return actor.second.IsReliable(now);
  });
  const auto may_be_asked = [&](const ActorMap::value_type& actor) {
    return !any_reliable || actor.second.IsReliable(now);
  };
  for (auto next = open_.begin(); next != open_.end();) {
    const std::uint64_t number = *next++;
    // Near the end no order waits in one actor's queue while another's slot may fall idle.
    const std::uint32_t per_slot = open_.size() <= slots() ? 1 : rules_.orders_per_slot;
    const Number& entry = numbers_.at(number);
    const bool again = !entry.heard.empty();
    ActorMap::value_type* actor =
        again ? Another(per_slot, entry) : LeastLoaded(per_slot, entry, may_be_asked);
    if (actor != nullptr) {
      HandOut(number, *actor, now, plan);
    } else if (!again) {
      return;
    }
  }
}

bool OrderLedger::MayPlay(const Number& number, const ActorMap::value_type& actor) const {
  return !Contains(number.heard, actor.first) &&
         !(number.disputed && Contains(number.hosts, HostOf(actor.first)));
}

bool OrderLedger::OtherHostIsThere(const Number& number) const {
  return std::any_of(actors_.begin(), actors_.end(), [&](const auto& actor) {
    return actor.second.silences == 0 && !Contains(number.hosts, HostOf(actor.first));
  });
}

// Whoever is on another host, were it busy or flapping: two processes of one machine may well make
// the same mistake.
OrderLedger::ActorMap::value_type* OrderLedger::Another(std::uint32_t orders_per_slot,
                                                        const Number& number) {
  const bool other_host = OtherHostIsThere(number);
  return LeastLoaded(orders_per_slot, number, [&](const ActorMap::value_type& actor) {
    return !other_host || !Contains(number.hosts, HostOf(actor.first));
  });
}

// What is late at everyone who plays it goes to one more idle slot: the first result wins.
void OrderLedger::PlanLate(TimePoint now, std::vector<Assignment>& plan) {
  if (!open_.empty()) return;
  const auto patience = Scaled(rules_.late_factor);
  std::map<std::uint64_t, bool> late;
  for (const auto& actor : actors_) {
    for (const Outstanding& out : actor.second.out) {
      const auto number = numbers_.find(out.number);
      if (number == numbers_.end() || number->second.state != Number::State::kOut) continue;
      bool& everywhere = late.emplace(out.number, true).first->second;
      everywhere = everywhere && now - out.since >= patience;
    }
  }
  for (const auto& [number, everywhere] : late) {
    if (!everywhere) continue;
    // Anybody's: the slot is idle, and a result that comes twice does no harm.
    ActorMap::value_type* actor =
        LeastLoaded(1, numbers_.at(number), [](const ActorMap::value_type&) { return true; });
    if (actor != nullptr) HandOut(number, *actor, now, plan);
  }
}

// The actor with the least orders per slot that does not play the number yet and takes another.
OrderLedger::ActorMap::value_type* OrderLedger::LeastLoaded(
    std::uint32_t orders_per_slot, const Number& number,
    const std::function<bool(const ActorMap::value_type&)>& may_be_asked) {
  ActorMap::value_type* best = nullptr;
  for (auto& candidate : actors_) {
    const Actor& actor = candidate.second;
    if (!may_be_asked(candidate)) continue;
    const std::size_t most = actor.silences > 0 ? 1 : std::size_t{actor.slots} * orders_per_slot;
    if (actor.out.size() >= most) continue;
    if (Contains(number.holders, candidate.first) || !MayPlay(number, candidate)) continue;
    if (best == nullptr ||
        actor.out.size() * best->second.slots < best->second.out.size() * actor.slots) {
      best = &candidate;
    }
  }
  return best;
}

void OrderLedger::HandOut(std::uint64_t number, ActorMap::value_type& actor, TimePoint now,
                          std::vector<Assignment>& plan) {
  Number& entry = numbers_.at(number);
  ++counts_.ordered;
  if (!entry.asked.empty() && entry.heard.empty()) ++counts_.reordered;
  open_.erase(number);
  entry.state = Number::State::kOut;
  ++entry.tries;
  entry.holders.push_back(actor.first);
  if (!Contains(entry.asked, actor.first)) entry.asked.push_back(actor.first);
  actor.second.out.push_back({number, now});

  const std::uint64_t version = BehaviourVersion(number);
  const auto same = std::find_if(plan.begin(), plan.end(), [&](const Assignment& assignment) {
    return assignment.actor_id == actor.first && assignment.weights_version == version;
  });
  if (same != plan.end()) {
    same->numbers.push_back(number);
  } else {
    plan.push_back({actor.first, version, {number}});
  }
}

std::optional<OrderLedger::TimePoint> OrderLedger::NextDeadline(TimePoint now) const {
  std::optional<TimePoint> next;
  const auto consider = [&next](TimePoint due) {
    if (!next || due < *next) next = due;
  };
  for (const auto& actor : actors_) {
    for (const TimePoint from : {actor.second.trusted_from, actor.second.rests_until}) {
      if (from > now) consider(from);
    }
    for (const Outstanding& out : actor.second.out) {
      // A late order without an idle slot waits for an event, not for time: then the loss is next.
      TimePoint due = out.since + Scaled(rules_.late_factor);
      if (due <= now) due = out.since + LostAfter(out);
      consider(due);
    }
  }
  return next;
}

std::chrono::nanoseconds OrderLedger::Scaled(double factor) const {
  const std::chrono::nanoseconds median =
      durations_.median().value_or(std::chrono::nanoseconds(rules_.first_estimate));
  // The floor keeps the proportion between late and lost.
  const double scale = factor / rules_.late_factor;
  const std::chrono::duration<double, std::nano> wanted = factor * median;
  const std::chrono::duration<double, std::nano> least =
      scale * std::chrono::nanoseconds(rules_.least_late);
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::max(wanted, least));
}

bool OrderLedger::IsComplete(std::uint64_t batch) const {
  return AcceptedOf(batch) == rules_.episodes_per_update;
}

std::uint64_t OrderLedger::AcceptedOf(std::uint64_t batch) const {
  const auto accepted = accepted_of_batch_.find(batch);
  return accepted == accepted_of_batch_.end() ? 0 : accepted->second;
}

std::vector<OrderLedger::ActorOrders> OrderLedger::OrdersByActor(TimePoint now) const {
  std::vector<ActorOrders> all;
  for (const auto& [id, actor] : actors_) {
    ActorOrders view{id,
                     actor.name,
                     actor.slots,
                     actor.out.size(),
                     std::nullopt,
                     actor.trusted_from <= now,
                     actor.silences > 0};
    for (const Outstanding& out : actor.out) {
      if (!view.oldest || out.since < *view.oldest) view.oldest = out.since;
    }
    all.push_back(std::move(view));
  }
  return all;
}

std::uint64_t OrderLedger::slots() const {
  std::uint64_t slots = 0;
  for (const auto& actor : actors_) slots += actor.second.slots;
  return slots;
}

void OrderLedger::CountIdle(TimePoint now) {
  if (counted_until_) {
    const double seconds = std::chrono::duration<double>(now - *counted_until_).count();
    for (const auto& actor : actors_) {
      const auto slots = static_cast<std::size_t>(actor.second.slots);
      slot_seconds_ += seconds * double(slots);
      idle_seconds_ += seconds * double(slots - std::min(slots, actor.second.out.size()));
    }
  }
  counted_until_ = now;
}

double OrderLedger::TakeIdleShare(TimePoint now) {
  CountIdle(now);
  const double share = slot_seconds_ > 0 ? idle_seconds_ / slot_seconds_ : 0;
  slot_seconds_ = 0;
  idle_seconds_ = 0;
  return share;
}

}  // namespace metronome
