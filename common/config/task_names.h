#pragma once

#include <string>
#include <vector>

/// The task names, known to learner and actors alike: those of the files in actor/metaworld/tasks,
/// taken over at build time. A unit test holds them and the environment's table together.
namespace metronome {

/// Canonical names, in alphabetical order.
const std::vector<std::string>& TaskNames();

/// Canonical name of any accepted spelling: X, X-v2 and X-v3 name the same task.
/// @throws std::invalid_argument for another name (names the near miss and the list).
std::string CanonicalTaskName(const std::string& spelling);

}  // namespace metronome
