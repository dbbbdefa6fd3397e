#pragma once

#include <CLI/CLI.hpp>
#include <optional>

/// Additions of both programs to CLI11: unknown names get their near miss, errors exit 2.
namespace metronome::text {

/// Parses the command line into `app`, whose subcommands are the program's commands; exactly one
/// must be given. Prints help to standard output, errors to standard error.
/// @return exit status 0 (help or version was asked for) or 2 (an error, said with the near miss
/// and
///         the list where a name is unknown); std::nullopt if the program shall go on.
std::optional<int> ParseCommandLine(CLI::App& app, int argc, const char* const* argv);

/// Prints `PROGRAM: message` and where help is, line by line, to standard error. @return 2.
int UsageError(const std::string& program, const std::string& message);

}  // namespace metronome::text
