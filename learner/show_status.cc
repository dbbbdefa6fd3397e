#include "learner/show_status.h"

#include <spdlog/spdlog.h>

#include <exception>
#include <iostream>
#include <stdexcept>

#include "common/dds/dds_bus.h"
#include "common/process/exit_codes.h"
#include "common/process/logging.h"
#include "learner/watch/follow.h"

namespace metronome::learner {
namespace {

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

int Watch(const StatusOptions& options) {
  const BusOptions bus_options = BusOptionsOf(options);
  const auto bus = dds::MakeDdsObserverBus(bus_options);
  const auto wait = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(options.wait_seconds));
  const auto ending =
      watch::ShowLearner(*bus, Clock::now() + wait, {options.json, options.follow}, std::cout);
  if (ending) return *ending;
  spdlog::error(
      "no learner of run {0} is heard within {1} s: {2}. Where its folder is, metronome-learner "
      "inspect runs/{0}/checkpoints/latest shows how far a run came that is over",
      options.run, options.wait_seconds, WhyNoLearner(bus_options, options.network));
  return process::kExitNoLearner;
}

}  // namespace

int WatchRun(const StatusOptions& options) {
  process::SetUpLogging("status", {});
  try {
    return Watch(options);
  } catch (const std::invalid_argument& error) {
    spdlog::error("{}", error.what());
    return process::kExitUsage;
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    return process::kExitFailure;
  }
}

}  // namespace metronome::learner
