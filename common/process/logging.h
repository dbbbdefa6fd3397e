#pragma once

#include <string>
#include <vector>

/// Set-up of spdlog, the one logger of both processes. Afterwards use spdlog::info and the like.
namespace metronome::process {

/// Accepted level names, most talkative first.
std::vector<std::string> LogLevels();
/// text: a line for people; json: an object a line, with time (UTC), level, process, pid, message.
std::vector<std::string> LogFormats();

struct LogOptions {
  std::string level = "info";   // one of LogLevels()
  std::string format = "text";  // one of LogFormats()
};

/// Sends spdlog's default logger to standard error, each line with time, process name and level.
/// Standard output stays free for results. Who logs never waits for who reads (OutputThread), but
/// for a tenth of a second after a warning or worse.
/// Call once at start, before threads.
/// @param process  "learner" or "actor".
/// @throws std::invalid_argument for an unknown level or format (names the near miss and the list).
void SetUpLogging(const std::string& process, const LogOptions& options);

}  // namespace metronome::process
