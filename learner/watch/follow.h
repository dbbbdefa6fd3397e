#pragma once

#include <iosfwd>
#include <optional>

#include "common/messages/bus.h"

namespace metronome::watch {

/// How learners are shown.
struct FollowOptions {
  bool json = false;    // an object a line instead of a table
  bool follow = false;  // each further status too, to the end
};

/// Shows the newest learner that is heard until `deadline`, or soon after the first.
/// @return process::kExitFinished, or process::kExitNoLearner if the learner followed is lost;
/// std::nullopt if none was heard. Bus errors pass through.
/// @throws std::runtime_error if `out` does not take it.
std::optional<int> ShowLearner(ObserverBus& bus, Clock::time_point deadline,
                               const FollowOptions& options, std::ostream& out);

}  // namespace metronome::watch
