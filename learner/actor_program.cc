#include "learner/actor_program.h"

#include <google/protobuf/text_format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>

#include "common/config/config_fields.h"
#include "common/process/exit_codes.h"

namespace metronome {
namespace {

/// A file in memory, for what a child says. @throws ConfigError.
class Sheet {
 public:
  Sheet() : descriptor_(memfd_create("metronome", MFD_CLOEXEC)) {
    if (descriptor_ < 0) throw ConfigError(std::string("memfd_create: ") + std::strerror(errno));
  }
  ~Sheet() { close(descriptor_); }
  Sheet(const Sheet&) = delete;
  Sheet& operator=(const Sheet&) = delete;

  [[nodiscard]] int descriptor() const { return descriptor_; }

  /// Without the last end of line.
  [[nodiscard]] std::string Text() const {
    std::string text;
    std::array<char, 4096> part{};
    for (ssize_t got;
         (got = pread(descriptor_, part.data(), part.size(), off_t(text.size()))) > 0;) {
      text.append(part.data(), std::size_t(got));
    }
    if (text.ends_with('\n')) text.pop_back();
    return text;
  }

 private:
  const int descriptor_;
};

struct Answer {
  int status = 0;  // as waitpid gives it
  std::string out;
  std::string err;
};

/// @throws ConfigError if the program cannot be run.
Answer Run(const std::string& program, std::initializer_list<std::string> words) {
  std::string name = program;
  std::vector<std::string> arguments(words);
  std::vector<char*> argv = {name.data()};
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const Sheet out, err;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, out.descriptor(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err.descriptor(), STDERR_FILENO);
  pid_t child = 0;
  const int failure = posix_spawn(&child, program.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  Answer answer;
  if (failure == 0) {
    while (waitpid(child, &answer.status, 0) < 0 && errno == EINTR) {
    }
    answer.out = out.Text();
    answer.err = err.Text();
    return answer;
  }
  throw ConfigError("cannot run " + program + ": " + std::strerror(failure) +
                    "; it says what environments are like, and lies beside this program in a whole "
                    "build (deploy/setup)");
}

EnvironmentSpec Ask(const std::string& name) {
  // To the program it would be no name.
  if (name.empty() || name.starts_with('-')) {
    throw std::invalid_argument("unknown environment \"" + name + '"');
  }
  const std::string program =
      std::filesystem::read_symlink("/proc/self/exe").replace_filename("metronome-actor").string();
  const Answer answer = Run(program, {"environment", name});
  if (WIFEXITED(answer.status) && WEXITSTATUS(answer.status) == kExitUsage) {
    throw std::invalid_argument(answer.err);
  }
  EnvironmentSpec spec;
  if (answer.status != 0 || !google::protobuf::TextFormat::ParseFromString(answer.out, &spec)) {
    throw ConfigError(program + " does not say what environment \"" + name +
                      "\" is like: " + (answer.err.empty() ? answer.out : answer.err));
  }
  return spec;
}

}  // namespace

SpecSource AskActorProgram() {
  const auto known = std::make_shared<std::map<std::string, EnvironmentSpec>>();
  return [known](const std::string& name) {
    const auto at = known->find(name);
    return at != known->end() ? at->second : known->emplace(name, Ask(name)).first->second;
  };
}

}  // namespace metronome
