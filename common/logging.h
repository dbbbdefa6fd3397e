#pragma once

#include <string>
#include <vector>

/// Set-up of spdlog, the one logger of both processes. Afterwards use spdlog::info and the like.
namespace metronome {

/// Accepted level names, most talkative first.
std::vector<std::string> LogLevels();

/// Sends spdlog's default logger to standard error, each line with time, process name and level;
/// warnings and worse are flushed at once. Standard output stays free for results.
/// Call once at start, before threads.
/// @param process  "learner" or "actor".
/// @param level    one of LogLevels().
/// @throws std::invalid_argument for another level (names the near miss and the list).
void SetUpLogging(const std::string& process, const std::string& level);

}  // namespace metronome
