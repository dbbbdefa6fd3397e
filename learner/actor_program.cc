#include "learner/actor_program.h"

#include <fcntl.h>
#include <google/protobuf/text_format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>

#include "common/config/config_fields.h"
#include "common/process/exit_codes.h"

namespace metronome::learner {
namespace {

/// From a child: files, those in memory too, obey a limit of file sizes.
class Pipe {
 public:
  /// @throws ConfigError.
  Pipe() {
    if (pipe2(ends_.data(), O_CLOEXEC) != 0) {
      throw config::ConfigError(std::string("cannot make a pipe: ") + std::strerror(errno));
    }
  }
  ~Pipe() {
    close(ends_[0]);
    CloseWriting();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  [[nodiscard]] int reading() const { return ends_[0]; }
  [[nodiscard]] int writing() const { return ends_[1]; }
  /// Else the end would never come.
  void CloseWriting() {
    if (ends_[1] >= 0) close(ends_[1]);
    ends_[1] = -1;
  }

 private:
  std::array<int, 2> ends_{};
};

/// @return false at the end.
bool ReadSome(int descriptor, std::string& text) {
  std::array<char, 4096> part{};
  const ssize_t got = read(descriptor, part.data(), part.size());
  if (got > 0) text.append(part.data(), std::size_t(got));
  return got > 0 || (got < 0 && errno == EINTR);
}

struct Answer {
  int status = 0;  // as waitpid gives it
  std::string out, err;
};

/// Reads both at once, so that the child never waits for the one that is not read.
void ReadBoth(const Pipe& out, const Pipe& err, Answer& answer) {
  std::array<pollfd, 2> ends = {{{out.reading(), POLLIN, 0}, {err.reading(), POLLIN, 0}}};
  while (ends[0].fd >= 0 || ends[1].fd >= 0) {
    if (poll(ends.data(), ends.size(), -1) < 0) continue;
    if (ends[0].revents != 0 && !ReadSome(ends[0].fd, answer.out)) ends[0].fd = -1;
    if (ends[1].revents != 0 && !ReadSome(ends[1].fd, answer.err)) ends[1].fd = -1;
  }
  if (answer.err.ends_with('\n')) answer.err.pop_back();
}

/// @throws ConfigError if the program cannot be run.
Answer Run(const std::string& program, std::initializer_list<std::string> words) {
  std::string name = program;
  std::vector<std::string> arguments(words);
  std::vector<char*> argv = {name.data()};
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  Pipe out, err;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, out.writing(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err.writing(), STDERR_FILENO);
  pid_t child = 0;
  const int failure = posix_spawn(&child, program.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failure != 0) {
    throw config::ConfigError(
        "cannot run " + program + ": " + std::strerror(failure) +
        "; it says what environments are like, and lies beside this program in a whole build "
        "(deploy/setup)");
  }
  out.CloseWriting();
  err.CloseWriting();
  Answer answer;
  ReadBoth(out, err, answer);
  while (waitpid(child, &answer.status, 0) < 0 && errno == EINTR) {
  }
  return answer;
}

EnvironmentSpec Ask(const std::string& name) {
  // To the program it would be no name.
  if (name.empty() || name.starts_with('-')) {
    throw std::invalid_argument("unknown environment \"" + name + '"');
  }
  const std::string program =
      std::filesystem::read_symlink("/proc/self/exe").replace_filename("metronome-actor").string();
  const Answer answer = Run(program, {"environment", name});
  if (WIFEXITED(answer.status) && WEXITSTATUS(answer.status) == process::kExitUsage) {
    throw std::invalid_argument(answer.err);
  }
  EnvironmentSpec spec;
  if (answer.status != 0 || !google::protobuf::TextFormat::ParseFromString(answer.out, &spec)) {
    throw config::ConfigError(program + " does not say what environment \"" + name +
                              "\" is like: " + (answer.err.empty() ? answer.out : answer.err));
  }
  return spec;
}

}  // namespace

config::SpecSource AskActorProgram() {
  const auto known = std::make_shared<std::map<std::string, EnvironmentSpec>>();
  return [known](const std::string& name) {
    const auto at = known->find(name);
    return at != known->end() ? at->second : known->emplace(name, Ask(name)).first->second;
  };
}

}  // namespace metronome::learner
