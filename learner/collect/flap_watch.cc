#include "learner/collect/flap_watch.h"

#include <algorithm>

#include "learner/collect/doubling.h"

namespace metronome {
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
    rows_.erase(stay.host);
    return;
  }
  Row& row = rows_[stay.host];
  if (row.flaps > 0 && now - row.last < kTogether) return;
  ++row.flaps;
  row.last = now;
}

std::uint32_t FlapWatch::FlapsOf(const std::string& host) const {
  const auto row = rows_.find(host);
  return row == rows_.end() ? 0 : row->second.flaps;
}

std::chrono::milliseconds FlapWatch::Probation(std::uint32_t flaps) const {
  return Doubling(flaps - std::min(flaps, rules_.allowed), rules_.first, rules_.longest);
}

}  // namespace metronome
