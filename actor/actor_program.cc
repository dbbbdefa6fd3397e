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
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>

#include "actor/client/actor_client.h"
#include "actor/options.h"
#include "actor/play/environment_player.h"
#include "actor/render/contact_sheet.h"
#include "actor/replay/task_list.h"
#include "common/dds/dds_bus.h"
#include "common/kernels/isa.h"
#include "common/process/build_info.h"
#include "common/process/cpu_count.h"
#include "common/process/cpu_times.h"
#include "common/process/exit_codes.h"
#include "common/process/ignored_signals.h"
#include "common/process/logging.h"
#include "common/process/process_identity.h"
#include "common/process/signal_watch.h"
#include "common/process/stop_target.h"

namespace metronome::actor {
namespace {

client::ActorClientOptions ClientOptions(const JoinOptions& options) {
  client::ActorClientOptions client;
  client.run_name = options.bus.run_name;
  client.why_no_learner = WhyNoLearner(options.bus, options.network);
  client.envs = options.envs;
  client.stay = options.stay;
  if (options.learner_timeout) {
    client.patience = std::chrono::milliseconds(std::llround(*options.learner_timeout * 1000));
  } else if (options.stay) {
    client.patience.reset();
  }
  client.actor_id = process::RandomId();
  client.host = process::HostName();
  client.pid = static_cast<std::uint32_t>(getpid());
  client.engine = process::EngineName();
  client.build = kernels::WithCurrentIsa(process::BuildIdentity());
  return client;
}

int StatusOf(client::ActorEnd end, int signal) {
  switch (end) {
    case client::ActorEnd::kFinished:
      return process::kExitFinished;
    case client::ActorEnd::kStopped:
      return process::kExitSignalBase + signal;
    case client::ActorEnd::kNoLearner:
      return process::kExitNoLearner;
    case client::ActorEnd::kRefused:
      break;
  }
  return process::kExitFailure;
}

/// @throws SetUpFailed for what options or this machine do not allow.
std::unique_ptr<ActorBus> MakeBus(const BusOptions& options, std::uint64_t actor_id) {
  try {
    return dds::MakeDdsActorBus(options, actor_id);
  } catch (const std::invalid_argument& error) {
    throw client::SetUpFailed(error.what());
  }
}

int Serve(const JoinOptions& options, const environment::EnvironmentRegistry& registry) {
  if (const auto warning = process::TooManyThreads(options.envs, "--envs"))
    spdlog::warn("{}", *warning);
  const client::ActorClientOptions client_options = ClientOptions(options);
  process::StopTarget target;
  // Before the bus, whose threads must inherit the blocked signals.
  const process::SignalWatch signals([&target](int number) { target.Signal(number); });
  const auto bus = MakeBus(options.bus, client_options.actor_id);
  client::ActorClient client(bus.get(), play::SetUpWith(registry), client_options);
  target.Set([&client](int) { client.Stop(); });
  const auto clear = [&target](client::ActorClient*) { target.Set(nullptr); };
  const std::unique_ptr<client::ActorClient, decltype(clear)> set(&client, clear);
  const client::ActorEnd end = client.Run();
  spdlog::info("{}", process::CpuTimes::OfProcess().Report());
  if (end == client::ActorEnd::kStopped) spdlog::info("stopped by signal {}", target.signal());
  return StatusOf(end, target.signal());
}

/// @throws SetUpFailed.
void RequireMachine(const environment::EnvironmentRegistry& registry) {
  try {
    registry.RequireMachine();
  } catch (const std::runtime_error& error) {
    throw client::SetUpFailed(error.what());
  }
}

int Execute(const JoinOptions& options, const environment::EnvironmentRegistry& registry) {
  process::SetUpLogging("actor", options.log);
  spdlog::info("{}, {}", kernels::WithCurrentIsa(process::BuildIdentity()), process::EngineName());
  process::IgnoreLostReaders();
  try {
    RequireMachine(registry);
    return Serve(options, registry);
  } catch (const client::SetUpFailed& error) {
    spdlog::error("{}", error.what());
    return process::kExitUsage;
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    return process::kExitFailure;
  }
}

/// Of the commands that come to an end by themselves: a stop needs no word, and nothing is left to
/// tidy, since what they write is whole or not there.
void EndAtOnce(int signal) { _exit(process::kExitSignalBase + signal); }

int Execute(const DescribeOptions& options, const environment::EnvironmentRegistry& registry) {
  std::string text;
  if (options.name.empty()) {
    for (const environment::EnvironmentEntry& entry : registry.entries())
      text += entry.spec.short_name() + "\n";
    for (const environment::TaskGroup& group : registry.groups()) text += group.name + "\n";
  } else {
    try {
      google::protobuf::TextFormat::PrintToString(registry.Describe(options.name), &text);
    } catch (const std::invalid_argument& error) {
      std::cerr << error.what() << '\n';
      return process::kExitUsage;
    }
  }
  std::cout << text << std::flush;
  return std::cout ? process::kExitFinished : process::kExitFailure;
}

int Execute(const TasksOptions& options, const environment::EnvironmentRegistry& registry) {
  if (options.picture.empty()) return replay::RunTasks(std::cout);
  return render::RunContactSheet(options.picture, registry, std::cout, std::cerr);
}
int Execute(const replay::TraceOptions& options,
            const environment::EnvironmentRegistry& /*registry*/) {
  return replay::RunTrace(options, std::cout);
}
int Execute(const replay::PlacementsOptions& options,
            const environment::EnvironmentRegistry& /*registry*/) {
  return replay::RunPlacements(options, std::cout);
}
int Execute(const play::EvaluateOptions& options,
            const environment::EnvironmentRegistry& registry) {
  return play::RunEvaluate(options, registry, std::cout, std::cerr);
}
int Execute(const render::RenderOptions& options,
            const environment::EnvironmentRegistry& registry) {
  return render::RunRender(options, registry, std::cout, std::cerr);
}

int Main(int argc, char** argv, const environment::EnvironmentRegistry& registry) {
  const auto parsed = ParseActorCommand(argc, argv, registry);
  if (const int* status = std::get_if<int>(&parsed)) return *status;
  const ActorCommand& command = std::get<ActorCommand>(parsed);
  std::optional<process::SignalWatch> signals;
  if (!std::holds_alternative<JoinOptions>(command)) signals.emplace(EndAtOnce);
  return std::visit([&registry](const auto& options) { return Execute(options, registry); },
                    command);
}

}  // namespace

int RunActorProgram(int argc, char** argv, const environment::EnvironmentRegistry& registry) {
  process::IgnoreFileSizeLimit();
  try {
    return Main(argc, argv, registry);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "metronome-actor: %s\n", error.what());
    return process::kExitFailure;
  }
}

}  // namespace metronome::actor
