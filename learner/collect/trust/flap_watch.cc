#include "learner/collect/trust/flap_watch.h"

#include <algorithm>

#include "learner/collect/trust/doubling.h"

namespace metronome::collect::trust {
namespace {

constexpr std::chrono::seconds kTogether{1};  // losses of one host within it are one

}  // namespace

FlapWatch::TimePoint FlapWatch::Join(std::uint64_t actor_id, const std::string& host,
                                     TimePoint now) {
  const auto [stay, joins] = stays_.try_emplace(actor_id, Stay{host, now, now});
  if (joins) stay->second.trusted_from = now + Probation(FlapsOf(host));
  return stay->second.trusted_from;
}

void FlapWatch::Lose(std::uint64_t actor_id, TimePoint now) {
  const auto found = stays_.find(actor_id);
  if (found == stays_.end()) return;
  const Stay stay = found->second;
  stays_.erase(found);
  if (now - stay.since >= rules_.steady) {
    rows_.Erase(stay.host);
    return;
  }
  const Row* row = rows_.Find(stay.host);
  if (row != nullptr && now - row->last < kTogether) return;
  rows_.Put(stay.host, {(row != nullptr ? row->flaps : 0) + 1, now});
}

std::uint32_t FlapWatch::FlapsOf(const std::string& host) const {
  const Row* row = rows_.Find(host);
  return row == nullptr ? 0 : row->flaps;
}

std::chrono::milliseconds FlapWatch::Probation(std::uint32_t flaps) const {
  return Doubling(flaps - std::min(flaps, rules_.allowed), rules_.first, rules_.longest);
}

}  // namespace metronome::collect::trust
