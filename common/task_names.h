#pragma once

#include <string>
#include <vector>

/// The one list of task names, known to learner and actors alike. The environment's table of tasks
/// (actor/metaworld) has the same names; a unit test holds the two together.
namespace metronome {

/// Canonical names, in alphabetical order.
const std::vector<std::string>& TaskNames();

/// Canonical name of any accepted spelling: X, X-v2 and X-v3 name the same task.
/// @throws std::invalid_argument for another name (names the near miss and the list).
std::string CanonicalTaskName(const std::string& spelling);

}  // namespace metronome
