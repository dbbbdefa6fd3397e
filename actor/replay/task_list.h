#pragma once

#include <ostream>

namespace metronome::replay {

/// `metronome-actor tasks`: all Meta-World tasks as a table for people, a line each after a head.
/// @return exit status: 0; 1 where `out` cannot be written.
int RunTasks(std::ostream& out);

}  // namespace metronome::replay
