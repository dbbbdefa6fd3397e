#pragma once

#include <string>

#include "common/messages/messages.h"

/// How `metronome-learner status` shows a learner. Pure functions.
namespace metronome::watch {

/// A learner speaks once a second; what it said this long ago need not be so any more.
inline constexpr double kOldStatusSeconds = 3;

/// A few lines about the run and a table of its actors, ending with a newline; an old
/// status says first that it is one.
std::string StatusTable(const LearnerStatus& status);
/// One JSON object in one line, without a newline; its names are those of LearnerStatus.
std::string StatusJson(const LearnerStatus& status);

}  // namespace metronome::watch
