#include "learner/follow.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <ostream>
#include <set>
#include <stdexcept>
#include <variant>

#include "learner/exit_codes.h"
#include "learner/status_text.h"

namespace metronome {
namespace {

// After the first learner another one may be heard, of a newer start.
constexpr std::chrono::milliseconds kGrace{300};

struct Found {
  LearnerStatus newest;
  bool lost = false;  // it is gone already: nobody will say so again
};

bool IsOver(const LearnerStatus& status) {
  return status.state == LearnerStatus::State::kFinished ||
         status.state == LearnerStatus::State::kStopped;
}

void Show(const LearnerStatus& status, bool json, std::ostream& out) {
  out << (json ? StatusJson(status) + "\n" : StatusTable(status)) << std::flush;
  if (!out) throw std::runtime_error("cannot write to standard output");
}

/// The newest learner that is heard until the deadline, or soon after the first.
std::optional<Found> Find(ObserverBus& bus, Clock::time_point deadline) {
  std::optional<LearnerStatus> newest;
  std::set<std::uint64_t> lost;
  while (const auto event = bus.Wait(deadline)) {
    if (const auto* bad = std::get_if<BadSample>(&*event)) spdlog::warn("{}", bad->reason);
    if (const auto* gone = std::get_if<LearnerLost>(&*event)) lost.insert(gone->learner_id);
    const auto* status = std::get_if<LearnerStatus>(&*event);
    if (status == nullptr) continue;
    lost.erase(status->learner_id);
    if (!newest) deadline = std::min(deadline, Clock::now() + kGrace);
    if (!newest || status->incarnation >= newest->incarnation) newest = *status;
  }
  if (!newest) return std::nullopt;
  return Found{*newest, lost.contains(newest->learner_id)};
}

int SayLost(const LearnerStatus& status) {
  spdlog::error("the learner of run {} is gone; its run goes on with --resume", status.run_name);
  return kExitNoLearner;
}

/// Shows each further status of this learner, or of a newer start, to the end. @return an ExitCode.
int Follow(ObserverBus& bus, Found found, bool json, std::ostream& out) {
  LearnerStatus& newest = found.newest;
  while (!IsOver(newest)) {
    if (found.lost) return SayLost(newest);
    const auto event = bus.Wait(Clock::time_point::max());
    if (!event) continue;
    const auto* gone = std::get_if<LearnerLost>(&*event);
    found.lost = gone != nullptr && gone->learner_id == newest.learner_id;
    const auto* status = std::get_if<LearnerStatus>(&*event);
    if (status == nullptr || status->incarnation < newest.incarnation) continue;
    newest = *status;
    Show(newest, json, out);
  }
  return kExitFinished;
}

}  // namespace

std::optional<int> ShowLearner(ObserverBus& bus, Clock::time_point deadline,
                               const FollowOptions& options, std::ostream& out) {
  const std::optional<Found> found = Find(bus, deadline);
  if (!found) return std::nullopt;
  Show(found->newest, options.json, out);
  return options.follow ? Follow(bus, *found, options.json, out) : kExitFinished;
}

}  // namespace metronome
