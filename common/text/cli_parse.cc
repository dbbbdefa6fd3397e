#include "common/text/cli_parse.h"

#include <iostream>
#include <string>
#include <vector>

#include "common/text/near_miss.h"

namespace metronome::text {
namespace {

/// Every "--name" that the command takes.
std::vector<std::string> OptionNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

std::vector<std::string> CommandNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

std::string ExplainExtra(const CLI::App& command, const std::string& extra) {
  if (!extra.starts_with('-')) return "unexpected argument \"" + extra + "\"";
  return UnknownName("option", extra.substr(0, extra.find('=')), OptionNames(command));
}

/// CLI11 takes whatever follows an option as its value; an option's name there is a forgotten
/// value.
std::optional<std::string> ForgottenValue(const CLI::App& command) {
  const auto names = OptionNames(command);
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& value : option->results()) {
      for (const std::string& name : names) {
        if (value != name && !value.starts_with(name + "=")) continue;
        return option->get_name() + " needs a value, but \"" + value + "\" follows";
      }
    }
  }
  return std::nullopt;
}

/// CLI11 counts values; a person typed an option again.
std::optional<std::string> GivenAgain(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    const auto count = option->results().size();
    const bool has_one = option->get_multi_option_policy() == CLI::MultiOptionPolicy::Throw &&
                         option->get_items_expected_max() == 1;
    if (!has_one || count < 2) continue;
    return option->get_name() + " is given " + std::to_string(count) +
           " times, and it has one value: \"" + option->results().front() + "\" or \"" +
           option->results().back() + "\"?";
  }
  return std::nullopt;
}

std::optional<std::string> Complaint(const CLI::App& app, const CLI::App* command) {
  if (command == nullptr) {
    const auto left = app.remaining();
    const auto commands = CommandNames(app);
    if (left.empty()) return "name a command: " + JoinNames(commands);
    if (left.front().starts_with('-')) return ExplainExtra(app, left.front());
    return UnknownName("command", left.front(), commands);
  }
  if (auto forgotten = ForgottenValue(*command)) return forgotten;
  // CLI11 may offer options that a command does not know to the program itself.
  for (const CLI::App* owner : {command, &app}) {
    const auto left = owner->remaining();
    if (!left.empty()) return ExplainExtra(*command, left.front());
  }
  return std::nullopt;
}

/// The command that was given; nullptr: none.
const CLI::App* CommandOf(const CLI::App& app) {
  const auto given = app.get_subcommands();
  return given.empty() ? nullptr : given.front();
}

std::string NameOf(const CLI::App& app) {
  const CLI::App* command = CommandOf(app);
  return app.get_name() + (command ? " " + command->get_name() : "");
}

}  // namespace

int UsageError(const std::string& program, const std::string& message) {
  std::size_t begin = 0;
  while (begin <= message.size()) {
    const std::size_t end = std::min(message.find('\n', begin), message.size());
    std::cerr << program << ": " << message.substr(begin, end - begin) << "\n";
    begin = end + 1;
  }
  std::cerr << "See " << program << " --help\n";
  return 2;
}

std::optional<int> ParseCommandLine(CLI::App& app, int argc, const char* const* argv) {
  // Unknown names are collected, to be explained here rather than by CLI11.
  app.allow_extras();
  app.require_subcommand(0, 1);  // a second command's name is an argument of the first
  for (CLI::App* command : app.get_subcommands({})) command->allow_extras();
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success, std::cout, std::cerr);
  } catch (const CLI::ParseError& error) {
    const auto again = CommandOf(app) ? GivenAgain(*CommandOf(app)) : std::nullopt;
    return UsageError(NameOf(app), again.value_or(error.what()));
  }
  const CLI::App* command = CommandOf(app);
  if (const auto complaint = Complaint(app, command)) return UsageError(NameOf(app), *complaint);
  return std::nullopt;
}

}  // namespace metronome::text
