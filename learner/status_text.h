#pragma once

#include <string>

#include "common/messages.h"

/// How `metronome-learner status` shows a learner. Pure functions.
namespace metronome {

/// A few lines about the run and a table of its actors, ending with a newline.
std::string StatusTable(const LearnerStatus& status);
/// One JSON object in one line, without a newline; its names are those of LearnerStatus.
std::string StatusJson(const LearnerStatus& status);

}  // namespace metronome
