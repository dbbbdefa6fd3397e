#include "learner/collect/trust/audit.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "common/numbers/random.h"
#include "learner/collect/trust/same_bits.h"

namespace metronome::collect::trust {
namespace {

using Opinions = std::vector<Audit::Opinion>;

bool Differ(const Opinions& opinions) {
  return std::any_of(opinions.begin(), opinions.end(), [&](const Audit::Opinion& other) {
    return !SameBits(opinions.front().episode, other.episode);
  });
}

void AddOnce(std::vector<std::string>* hosts, const std::string& host) {
  if (std::find(hosts->begin(), hosts->end(), host) == hosts->end()) hosts->push_back(host);
}

void Erase(Opinions* opinions, const std::string& host) {
  std::erase_if(*opinions, [&](const Audit::Opinion& opinion) { return opinion.host == host; });
}

/// A host whose own actors differ, if there is one.
std::optional<std::string> Contradiction(const Opinions& opinions) {
  for (const Audit::Opinion& one : opinions) {
    for (const Audit::Opinion& other : opinions) {
      if (one.host == other.host && !SameBits(one.episode, other.episode)) return one.host;
    }
  }
  return std::nullopt;
}

/// The first opinion that another actor shares; where hosts differ, one of another host.
const Audit::Opinion* Shared(const Opinions& opinions) {
  const bool differ = Differ(opinions);
  for (const Audit::Opinion& one : opinions) {
    for (const Audit::Opinion& other : opinions) {
      const bool another = differ ? one.host != other.host : one.actor_id != other.actor_id;
      if (another && SameBits(one.episode, other.episode)) return &one;
    }
  }
  return nullptr;
}

}  // namespace

bool Audit::IsChosen(std::uint64_t number) const {
  if (doubted_.contains(number)) return true;
  return on() &&
         numbers::RandomStream(numbers::RandomPurpose::kAudit, rules_.key, number, 0).Uniform() <
             rules_.share;
}

Audit::Verdict Audit::Hear(Opinion opinion) {
  const std::uint64_t number = opinion.episode.number;
  const bool was_disputed = IsDisputed(number);
  Opinions& opinions = pending_[number];
  opinions.push_back(std::move(opinion));
  if (!was_disputed && Differ(opinions)) ++counts_.disputes;

  Verdict verdict;
  while (const auto host = Contradiction(opinions)) {
    AddOnce(&verdict.guilty, *host);
    Erase(&opinions, *host);
  }
  if (const Opinion* shared = Shared(opinions)) {
    for (const Opinion& other : opinions) {
      const bool same = SameBits(shared->episode, other.episode);
      AddOnce(same ? &verdict.vouchers : &verdict.guilty, other.host);
    }
    verdict.settled = *shared;
    ++counts_.agreed;
  }
  verdict.disputed = !verdict.settled && Differ(opinions);
  if (verdict.settled || opinions.empty()) pending_.erase(number);
  return verdict;
}

Audit::Opinion Audit::SettleAlone(std::uint64_t number) {
  const auto found = pending_.find(number);
  if (found == pending_.end() || IsDisputed(number)) {
    throw std::logic_error("episode " + std::to_string(number) + " has no opinion that may stand");
  }
  Opinion only = std::move(found->second.front());
  pending_.erase(found);
  ++counts_.alone;
  return only;
}

std::vector<std::uint64_t> Audit::Pending() const {
  std::vector<std::uint64_t> numbers;
  for (const auto& entry : pending_) numbers.push_back(entry.first);
  return numbers;
}

bool Audit::IsDisputed(std::uint64_t number) const {
  const auto found = pending_.find(number);
  return found != pending_.end() && Differ(found->second);
}

std::vector<std::uint64_t> Audit::Forget(const std::string& host) {
  std::vector<std::uint64_t> unheard;
  for (auto entry = pending_.begin(); entry != pending_.end();) {
    Erase(&entry->second, host);
    if (!entry->second.empty()) {
      ++entry;
      continue;
    }
    unheard.push_back(entry->first);
    entry = pending_.erase(entry);
  }
  return unheard;
}

}  // namespace metronome::collect::trust
