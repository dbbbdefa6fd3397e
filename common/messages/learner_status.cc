#include "common/messages/learner_status.h"

namespace metronome {

std::string StateText(LearnerState state) {
  switch (state) {
    case LearnerState::kWaitingForActors:
      return "waiting for actors";
    case LearnerState::kCollecting:
      return "collecting";
    case LearnerState::kUpdating:
      return "updating";
    case LearnerState::kFinished:
      return "finished";
    case LearnerState::kStopped:
      return "stopped";
  }
  return "unknown";
}

}  // namespace metronome
