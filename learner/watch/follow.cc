#include "learner/watch/follow.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ostream>
#include <set>
#include <stdexcept>
#include <variant>

#include "common/process/exit_codes.h"
#include "learner/watch/status_text.h"

namespace metronome::watch {
namespace {

// After the first learner another one may be heard, of a newer incarnation.
constexpr std::chrono::milliseconds kGrace{300};

Clock::duration TicksOf(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

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

// A late joiner gets the last status however old it is. Its age is the difference of two hosts'
// clocks: believed where it says that a second has hardly passed.
bool LooksFresh(const LearnerStatus& status) { return std::abs(status.age_seconds) < 2; }

/// The newest learner that is heard until the deadline, or soon after the first. Where that one's
/// status does not look fresh, it has time to speak again, which settles it.
std::optional<Found> Find(ObserverBus& bus, Clock::time_point deadline) {
  std::optional<LearnerStatus> newest;
  std::set<std::uint64_t> lost;
  while (const auto event = bus.Wait(deadline)) {
    if (const auto* bad = std::get_if<BadSample>(&*event)) spdlog::warn("{}", bad->reason);
    if (const auto* gone = std::get_if<LearnerLost>(&*event)) lost.insert(gone->learner_id);
    const auto* status = std::get_if<LearnerStatus>(&*event);
    if (status == nullptr) continue;
    lost.erase(status->learner_id);
    const bool again = newest && newest->learner_id == status->learner_id;
    if (!newest || again) {
      const bool settled = again || LooksFresh(*status);
      deadline = std::min(deadline, Clock::now() + (settled ? kGrace : TicksOf(kOldStatusSeconds)));
    }
    if (newest && status->incarnation < newest->incarnation) continue;
    newest = *status;
    if (again) newest->age_seconds = 0;
  }
  if (!newest) return std::nullopt;
  if (!LooksFresh(*newest)) newest->age_seconds = std::max(newest->age_seconds, kOldStatusSeconds);
  return Found{*newest, lost.contains(newest->learner_id)};
}

int SayLost(const LearnerStatus& status) {
  spdlog::error("the learner of run {} is gone; its run goes on with --resume", status.run_name);
  return process::kExitNoLearner;
}

/// Shows each further status of this learner, or of a newer incarnation, to the end, and in its
/// silence the last one again with its age. @return an ExitCode.
int Follow(ObserverBus& bus, Found found, bool json, std::ostream& out) {
  LearnerStatus& newest = found.newest;
  auto made = Clock::now() - TicksOf(newest.age_seconds);
  while (!IsOver(newest)) {
    if (found.lost) return SayLost(newest);
    const auto event = bus.Wait(Clock::now() + TicksOf(kOldStatusSeconds));
    if (!event) {
      newest.age_seconds = std::chrono::duration<double>(Clock::now() - made).count();
      Show(newest, json, out);
      continue;
    }
    const auto* gone = std::get_if<LearnerLost>(&*event);
    found.lost = gone != nullptr && gone->learner_id == newest.learner_id;
    const auto* status = std::get_if<LearnerStatus>(&*event);
    if (status == nullptr || status->incarnation < newest.incarnation) continue;
    newest = *status;
    newest.age_seconds = 0;  // it comes as it is written
    made = Clock::now();
    Show(newest, json, out);
  }
  return process::kExitFinished;
}

}  // namespace

std::optional<int> ShowLearner(ObserverBus& bus, Clock::time_point deadline,
                               const FollowOptions& options, std::ostream& out) {
  const std::optional<Found> found = Find(bus, deadline);
  if (!found) return std::nullopt;
  Show(found->newest, options.json, out);
  return options.follow ? Follow(bus, *found, options.json, out) : process::kExitFinished;
}

}  // namespace metronome::watch
