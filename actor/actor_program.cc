#include "actor/actor_program.h"

#include <google/protobuf/text_format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <iostream>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>

#include "actor/client/actor_client.h"
#include "actor/options.h"
#include "actor/play/environment_player.h"
#include "common/dds/dds_bus.h"
#include "common/process/build_info.h"
#include "common/process/cpu_count.h"
#include "common/process/cpu_times.h"
#include "common/process/exit_codes.h"
#include "common/process/ignored_signals.h"
#include "common/process/logging.h"
#include "common/process/process_identity.h"
#include "common/process/signal_watch.h"

namespace metronome {
namespace {

ActorClientOptions ClientOptions(const JoinOptions& options) {
  ActorClientOptions client;
  client.run_name = options.bus.run_name;
  client.domain = options.bus.domain;
  client.slots = options.envs;
  client.stay = options.stay;
  if (options.learner_timeout) {
    client.patience = std::chrono::milliseconds(std::llround(*options.learner_timeout * 1000));
  } else if (options.stay) {
    client.patience.reset();
  }
  client.actor_id = RandomId();
  client.host = HostName();
  client.pid = static_cast<std::uint32_t>(getpid());
  client.engine = EngineName();
  client.build = BuildIdentity();
  return client;
}

int StatusOf(ActorEnd end, int signal) {
  switch (end) {
    case ActorEnd::kFinished:
      return kExitFinished;
    case ActorEnd::kStopped:
      return kExitSignalBase + signal;
    case ActorEnd::kNoLearner:
      return kExitNoLearner;
    case ActorEnd::kRefused:
      break;
  }
  return kExitFailure;
}

/// Whom a signal stops, while there is someone.
class StopTarget {
 public:
  void Set(ActorClient* client) {
    const std::lock_guard lock(mutex_);
    client_ = client;
    if (client_ != nullptr && signal_ != 0) client_->Stop();
  }
  void Signal(int number) {
    const std::lock_guard lock(mutex_);
    signal_ = number;
    if (client_ != nullptr) client_->Stop();
  }
  int signal() const {
    const std::lock_guard lock(mutex_);
    return signal_;
  }

 private:
  mutable std::mutex mutex_;
  ActorClient* client_ = nullptr;
  int signal_ = 0;
};

/// @throws SetUpFailed for what options or this machine do not allow.
std::unique_ptr<ActorBus> MakeBus(const BusOptions& options, std::uint64_t actor_id) {
  try {
    return MakeDdsActorBus(options, actor_id);
  } catch (const std::invalid_argument& error) {
    throw SetUpFailed(error.what());
  }
}

int Serve(const JoinOptions& options, const EnvironmentRegistry& registry) {
  if (const auto warning = TooManyThreads(options.envs, "--envs")) spdlog::warn("{}", *warning);
  const ActorClientOptions client_options = ClientOptions(options);
  StopTarget target;
  // Before the bus, whose threads must inherit the blocked signals.
  const SignalWatch signals([&target](int number) { target.Signal(number); });
  const auto bus = MakeBus(options.bus, client_options.actor_id);
  ActorClient client(bus.get(), SetUpWith(registry), client_options);
  target.Set(&client);
  const auto clear = [&target](ActorClient*) { target.Set(nullptr); };
  const std::unique_ptr<ActorClient, decltype(clear)> set(&client, clear);
  const ActorEnd end = client.Run();
  spdlog::info("{}", CpuTimes::OfProcess().Report());
  if (end == ActorEnd::kStopped) spdlog::info("stopped by signal {}", target.signal());
  return StatusOf(end, target.signal());
}

/// @throws SetUpFailed.
void RequireMachine(const EnvironmentRegistry& registry) {
  try {
    registry.RequireMachine();
  } catch (const std::runtime_error& error) {
    throw SetUpFailed(error.what());
  }
}

int Execute(const JoinOptions& options, const EnvironmentRegistry& registry) {
  SetUpLogging("actor", options.log);
  IgnoreLostReaders();
  try {
    RequireMachine(registry);
    return Serve(options, registry);
  } catch (const SetUpFailed& error) {
    spdlog::error("{}", error.what());
    return kExitUsage;
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    return kExitFailure;
  }
}

/// Of the commands that come to an end by themselves: a stop needs no word, and nothing is left to
/// tidy, since what they write is whole or not there.
void EndAtOnce(int signal) { _exit(kExitSignalBase + signal); }

int Execute(const DescribeOptions& options, const EnvironmentRegistry& registry) {
  std::string text;
  if (options.name.empty()) {
    for (const EnvironmentEntry& entry : registry.entries()) text += entry.spec.short_name() + "\n";
  } else {
    try {
      google::protobuf::TextFormat::PrintToString(registry.Describe(options.name), &text);
    } catch (const std::invalid_argument& error) {
      std::cerr << error.what() << '\n';
      return kExitUsage;
    }
  }
  std::cout << text << std::flush;
  return std::cout ? kExitFinished : kExitFailure;
}

int Execute(const TraceOptions& options, const EnvironmentRegistry& /*registry*/) {
  return RunTrace(options, std::cout);
}
int Execute(const PlacementsOptions& options, const EnvironmentRegistry& /*registry*/) {
  return RunPlacements(options, std::cout);
}
int Execute(const EvaluateOptions& options, const EnvironmentRegistry& registry) {
  return RunEvaluate(options, registry, std::cout, std::cerr);
}
int Execute(const RenderOptions& options, const EnvironmentRegistry& registry) {
  return RunRender(options, registry, std::cout, std::cerr);
}

int Main(int argc, char** argv, const EnvironmentRegistry& registry) {
  const auto parsed = ParseActorCommand(argc, argv, registry);
  if (const int* status = std::get_if<int>(&parsed)) return *status;
  const ActorCommand& command = std::get<ActorCommand>(parsed);
  std::optional<SignalWatch> signals;
  if (!std::holds_alternative<JoinOptions>(command)) signals.emplace(EndAtOnce);
  return std::visit([&registry](const auto& options) { return Execute(options, registry); },
                    command);
}

}  // namespace

int RunActorProgram(int argc, char** argv, const EnvironmentRegistry& registry) {
  IgnoreFileSizeLimit();
  try {
    return Main(argc, argv, registry);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "metronome-actor: %s\n", error.what());
    return kExitFailure;
  }
}

}  // namespace metronome
