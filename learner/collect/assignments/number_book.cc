#include "learner/collect/assignments/number_book.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace metronome::collect::assignments {
namespace {

using Player = NumberBook::Player;
using Number = NumberBook::Number;

bool Contains(const std::vector<std::uint64_t>& actors, std::uint64_t actor_id) {
  return std::find(actors.begin(), actors.end(), actor_id) != actors.end();
}

const Player* FindPlayer(const std::vector<Player>& players, std::uint64_t actor_id) {
  const auto player = std::find_if(players.begin(), players.end(),
                                   [&](const Player& one) { return one.actor_id == actor_id; });
  return player == players.end() ? nullptr : &*player;
}

/// Else actors that come, are asked and go without an answer would be kept for as long as a number
/// is missing. Who was asked longest ago goes first; should it answer after all, another is asked.
void ForgetOldest(Number* number) {
  if (number->asked.size() <= NumberBook::kAskedKept) return;
  const auto oldest =
      std::find_if(number->asked.begin(), number->asked.end(),
                   [&](const Player& one) { return !Contains(number->holders, one.actor_id); });
  if (oldest != number->asked.end()) number->asked.erase(oldest);
}

}  // namespace

bool NumberBook::Number::WasHeardOn(const std::string& host) const {
  return std::any_of(heard.begin(), heard.end(),
                     [&](const Player& one) { return one.host == host; });
}

bool NumberBook::Number::MayBePlayedBy(std::uint64_t actor_id, const std::string& host) const {
  return FindPlayer(heard, actor_id) == nullptr && !(disputed && WasHeardOn(host));
}

NumberBook::NumberBook(const AssignmentRules& rules)
    : rules_(rules), version_(rules.first_version), next_batch_(rules.first_version) {
  if (rules.episodes_per_update == 0 || rules.assignments_per_env == 0 ||
      rules.updates_total == 0) {
    throw std::invalid_argument("assignment rules: a count is 0");
  }
  if (rules.first_version > rules.updates_total) {
    throw std::invalid_argument("assignment rules: the first version lies behind the last update");
  }
  OpenBatches();
}

void NumberBook::OpenBatches() {
  const std::uint64_t end = std::min(rules_.updates_total, version_ + rules_.overlap + 1);
  for (; next_batch_ < end; ++next_batch_) {
    const std::uint64_t first = next_batch_ * rules_.episodes_per_update;
    for (std::uint64_t i = 0; i < rules_.episodes_per_update; ++i) {
      numbers_.emplace(first + i, Number{});
      open_.insert(first + i);
    }
  }
}

// It is not here (any more): whoever has it in hand may bring it, else it is to be handed out.
void NumberBook::Open(std::uint64_t number) {
  Number& entry = numbers_.at(number);
  Close(number);
  entry.state = Number::State::kOut;
  if (!entry.holders.empty()) return;
  entry.state = Number::State::kOpen;
  (entry.heard.empty() ? open_ : open_again_).insert(number);
}

void NumberBook::Close(std::uint64_t number) {
  open_.erase(number);
  open_again_.erase(number);
}

NumberBook::Claim NumberBook::ClaimOf(std::uint64_t number, std::uint64_t actor_id) const {
  using Standing = Claim::Standing;
  Claim claim;
  claim.weights_version = BehaviourVersion(rules_, number);
  if (number < version_ * rules_.episodes_per_update) claim.standing = Standing::kDuplicate;
  const Number* entry = Find(number);
  if (entry == nullptr) return claim;
  const Player* asked = FindPlayer(entry->asked, actor_id);
  if (asked != nullptr) claim.host = asked->host;
  if (entry->state == Number::State::kAccepted || FindPlayer(entry->heard, actor_id) != nullptr) {
    claim.standing = Standing::kDuplicate;
  } else if (asked != nullptr && entry->state != Number::State::kArrived) {
    claim.standing = Standing::kWanted;
  }
  return claim;
}

bool NumberBook::HandOut(std::uint64_t number, const Player& player) {
  Number& entry = numbers_.at(number);
  const bool first = entry.asked.empty() || !entry.heard.empty();
  Close(number);
  entry.state = Number::State::kOut;
  ++entry.tries;
  entry.holders.push_back(player.actor_id);
  std::erase_if(entry.asked, [&](const Player& one) { return one.actor_id == player.actor_id; });
  entry.asked.push_back(player);
  ForgetOldest(&entry);
  return first;
}

void NumberBook::TakeBack(std::uint64_t number, std::uint64_t actor_id) {
  const auto entry = numbers_.find(number);
  if (entry == numbers_.end()) return;
  std::erase(entry->second.holders, actor_id);
  if (entry->second.state == Number::State::kOut) Open(number);
}

void NumberBook::Arrive(std::uint64_t number) {
  Number& entry = numbers_.at(number);
  if (entry.state != Number::State::kOpen && entry.state != Number::State::kOut) {
    throw std::logic_error("episode " + std::to_string(number) + " is not missing");
  }
  Close(number);
  entry.state = Number::State::kArrived;
}

void NumberBook::Accept(std::uint64_t number, std::vector<std::string> vouchers) {
  Number& entry = numbers_.at(number);
  if (entry.state == Number::State::kAccepted) {
    throw std::logic_error("episode " + std::to_string(number) + " is accepted already");
  }
  Close(number);
  entry.state = Number::State::kAccepted;
  entry.vouchers = std::move(vouchers);
  ++accepted_of_batch_[number / rules_.episodes_per_update];
}

void NumberBook::PutBack(std::uint64_t number) { Open(number); }

void NumberBook::AskAnother(std::uint64_t number, const Player& heard, bool disputed) {
  Number& entry = numbers_.at(number);
  entry.heard.push_back(heard);
  entry.disputed = disputed;
  Open(number);
}

void NumberBook::Reopen(std::uint64_t number) {
  Number& entry = numbers_.at(number);
  if (entry.state == Number::State::kAccepted) {
    --accepted_of_batch_.at(number / rules_.episodes_per_update);
  }
  entry.heard.clear();
  entry.vouchers.clear();
  entry.disputed = false;
  Open(number);
}

const NumberBook::Number* NumberBook::Find(std::uint64_t number) const {
  const auto entry = numbers_.find(number);
  return entry == numbers_.end() ? nullptr : &entry->second;
}

std::vector<std::uint64_t> NumberBook::OnTheWordOf(const std::string& host) const {
  std::vector<std::uint64_t> numbers;
  for (const auto& [number, entry] : numbers_) {
    const bool alone = entry.vouchers.size() == 1 && entry.vouchers.front() == host;
    if (entry.state == Number::State::kAccepted && alone) numbers.push_back(number);
  }
  return numbers;
}

std::uint64_t NumberBook::AcceptedOf(std::uint64_t batch) const {
  const auto accepted = accepted_of_batch_.find(batch);
  return accepted == accepted_of_batch_.end() ? 0 : accepted->second;
}

void NumberBook::Publish(std::uint64_t version) {
  if (version != version_ + 1 || AcceptedOf(version_) != rules_.episodes_per_update) {
    throw std::logic_error("weights version " + std::to_string(version) + " does not follow");
  }
  numbers_.erase(numbers_.begin(), numbers_.lower_bound(version * rules_.episodes_per_update));
  accepted_of_batch_.erase(version_);
  version_ = version;
  OpenBatches();
}

}  // namespace metronome::collect::assignments
