#include "learner/watch.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <variant>

#include "common/dds/dds_bus.h"
#include "common/logging.h"
#include "learner/exit_codes.h"
#include "learner/status_text.h"

namespace metronome {
namespace {

// After the first learner another one may be heard, of a newer start.
constexpr std::chrono::milliseconds kGrace{300};

BusOptions BusOptionsOf(const StatusOptions& options) {
  BusOptions bus;
  bus.run_name = options.run;
  bus.domain = options.domain;
  bus.transport = ParseTransport(options.transport);
  bus.network = ParseNetwork(options.network);
  bus.security = options.security;
  bus.discovery_servers = ParseDiscoveryServers(options.discovery_server);
  CheckBusOptions(bus);
  return bus;
}

bool IsOver(const LearnerStatus& status) {
  return status.state == LearnerStatus::State::kFinished ||
         status.state == LearnerStatus::State::kStopped;
}

void Show(const LearnerStatus& status, bool json) {
  std::cout << (json ? StatusJson(status) + "\n" : StatusTable(status)) << std::flush;
}

/// The newest learner's status that is heard until the deadline, or soon after the first.
std::optional<LearnerStatus> Find(ObserverBus& bus, Clock::time_point deadline) {
  std::optional<LearnerStatus> newest;
  while (const auto event = bus.Wait(deadline)) {
    if (const auto* bad = std::get_if<BadSample>(&*event)) spdlog::warn("{}", bad->reason);
    const auto* status = std::get_if<LearnerStatus>(&*event);
    if (status == nullptr) continue;
    if (!newest) deadline = std::min(deadline, Clock::now() + kGrace);
    if (!newest || status->incarnation >= newest->incarnation) newest = *status;
  }
  return newest;
}

/// Shows each further status of this learner, or of a newer start, to the end. @return an ExitCode.
int Follow(ObserverBus& bus, LearnerStatus newest, bool json) {
  while (!IsOver(newest)) {
    const auto event = bus.Wait(Clock::time_point::max());
    if (!event) continue;
    if (const auto* lost = std::get_if<LearnerLost>(&*event)) {
      if (lost->learner_id != newest.learner_id) continue;
      spdlog::error("the learner of run {} is gone; its run goes on with --resume",
                    newest.run_name);
      return kExitNoLearner;
    }
    const auto* status = std::get_if<LearnerStatus>(&*event);
    if (status == nullptr || status->incarnation < newest.incarnation) continue;
    newest = *status;
    Show(newest, json);
  }
  return kExitFinished;
}

int Watch(const StatusOptions& options) {
  const auto bus = MakeDdsObserverBus(BusOptionsOf(options));
  const auto wait = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(options.wait_seconds));
  const auto newest = Find(*bus, Clock::now() + wait);
  if (!newest) {
    spdlog::error(
        "no learner of run {} is heard within {} s (domain {}, network {}): is it running, and "
        "were --run, --domain, --transport, --network, --discovery-server and the authority of "
        "--security the same there? On another machine it must not have been started with "
        "--network loopback",
        options.run, options.wait_seconds, options.domain, options.network);
    return kExitNoLearner;
  }
  Show(*newest, options.json);
  return options.follow ? Follow(*bus, *newest, options.json) : kExitFinished;
}

}  // namespace

int WatchRun(const StatusOptions& options) {
  SetUpLogging("status", {});
  try {
    return Watch(options);
  } catch (const std::invalid_argument& error) {
    spdlog::error("{}", error.what());
    return kExitUsage;
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    return kExitFailure;
  }
}

}  // namespace metronome
