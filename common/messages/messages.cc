#include "common/messages/messages.h"

namespace metronome {

std::string HostOfName(const std::string& name) { return name.substr(0, name.rfind(':')); }

std::string StateText(LearnerStatus::State state) {
  switch (state) {
    case LearnerStatus::State::kWaitingForActors:
      return "waiting for actors";
    case LearnerStatus::State::kCollecting:
      return "collecting";
    case LearnerStatus::State::kUpdating:
      return "updating";
    case LearnerStatus::State::kFinished:
      return "finished";
    case LearnerStatus::State::kStopped:
      return "stopped";
  }
  return "unknown";
}

}  // namespace metronome
