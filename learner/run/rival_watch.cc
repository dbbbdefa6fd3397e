#include "learner/run/rival_watch.h"

#include <algorithm>

namespace metronome::run {

RivalWatch::RivalWatch(std::uint64_t own_id, const RivalTimes& times, TimePoint started)
    : own_id_(own_id), times_(times), started_(started) {}

void RivalWatch::See(const RunDescription& rival, TimePoint now) {
  if (rival.learner_id == own_id_) return;
  const auto [entry, first] = rivals_.try_emplace(rival.learner_id, Rival{rival, now});
  if (!first) {
    // A rival that begins to serve is a new fact: its time to vanish begins anew once we serve too.
    if (serving_since_ && rival.serving && !entry->second.description.serving) {
      entry->second.seen = now;
    }
    entry->second.description = rival;
  }
}

void RivalWatch::Lose(std::uint64_t learner_id) { rivals_.erase(learner_id); }

void RivalWatch::Serve(TimePoint now) { serving_since_ = now; }

std::optional<RivalWatch::TimePoint> RivalWatch::YieldsAt(const Rival& rival) const {
  const bool lower = rival.description.learner_id < own_id_;
  if (!serving_since_) {
    if (!rival.description.serving && !lower) return std::nullopt;
    return rival.seen + times_.lease;
  }
  if (!rival.description.serving) return std::nullopt;
  const bool young = rival.seen < *serving_since_ + times_.lease;
  if (young) return rival.seen + times_.lease * (lower ? 1 : 2);
  if (lower) return rival.seen + times_.lease * 3;
  return std::nullopt;
}

bool RivalWatch::MayServe(TimePoint now) const {
  return now >= started_ + times_.discovery &&
         std::none_of(rivals_.begin(), rivals_.end(),
                      [&](const auto& rival) { return YieldsAt(rival.second).has_value(); });
}

std::optional<std::string> RivalWatch::MustStop(TimePoint now) const {
  for (const auto& [id, rival] : rivals_) {
    const auto at = YieldsAt(rival);
    if (!at || now < *at) continue;
    return "run " + rival.description.run_name + " has another learner, which " +
           (rival.description.serving ? "serves it" : "starts as well and has the lower id") +
           ": id " + std::to_string(id) + ", incarnation " +
           std::to_string(rival.description.incarnation) + ", " + rival.description.build;
  }
  return std::nullopt;
}

std::optional<RivalWatch::TimePoint> RivalWatch::NextDeadline(TimePoint now) const {
  std::optional<TimePoint> next;
  const auto consider = [&](std::optional<TimePoint> at) {
    if (at && *at > now && (!next || *at < *next)) next = at;
  };
  if (!serving_since_) consider(started_ + times_.discovery);
  for (const auto& rival : rivals_) consider(YieldsAt(rival.second));
  return next;
}

}  // namespace metronome::run
