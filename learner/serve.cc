#include "learner/serve.h"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "common/config/config.h"
#include "common/config/config_fields.h"
#include "common/dds/dds_bus.h"
#include "common/dds/machine.h"
#include "common/dds/security/security.h"
#include "common/kernels/isa.h"
#include "common/process/build_info.h"
#include "common/process/cpu_count.h"
#include "common/process/cpu_times.h"
#include "common/process/ignored_signals.h"
#include "common/process/logging.h"
#include "common/process/output_thread.h"
#include "common/process/process_identity.h"
#include "common/process/signal_watch.h"
#include "common/process/stop_target.h"
#include "learner/collect/trust/excluded_hosts.h"
#include "learner/exit_code.h"
#include "learner/record/file_run_record.h"
#include "learner/record/run_folder.h"
#include "learner/run/background.h"
#include "learner/run/coordinator.h"
#include "learner/run/run_start.h"
#include "learner/watch/metrics_server.h"

namespace metronome::learner {
namespace {

std::string HostAndProcess() {
  return "on " + process::HostName() + ", process " + std::to_string(getpid());
}

BusOptions BusOptionsOf(const RunOptions& options) {
  BusOptions bus;
  bus.run_name = options.run;
  bus.domain = options.config.runtime().domain();
  bus.transport = ParseTransport(options.config.runtime().transport());
  bus.network = ParseNetwork(options.config.runtime().network());
  bus.security = options.config.runtime().security();
  bus.discovery_servers = ParseDiscoveryServers(options.config.runtime().discovery_server());
  CheckBusOptions(bus);
  dds::security::CheckIdentity(bus, "learner");
  return bus;
}

std::uint64_t DividedUp(std::uint64_t number, std::uint64_t by) {
  return number / by + (number % by == 0 ? 0 : 1);
}

/// Of whole updates, if none of their episodes ends early.
record::RunLength LengthOf(const RunConfig& config) {
  const auto steps_per_update =
      static_cast<std::uint64_t>(config.collection().episodes_per_update()) *
      static_cast<std::uint64_t>(config.environment().horizon());
  record::RunLength length;
  length.varies = config.environment().spec().may_end_early();
  length.updates = DividedUp(config.total_steps(), steps_per_update);
  length.total_steps = length.varies ? config.total_steps() : length.updates * steps_per_update;
  return length;
}

/// Updates that reach the total if each episode has a single step.
std::uint64_t MostUpdates(const RunConfig& config) {
  const record::RunLength length = LengthOf(config);
  if (!length.varies) return length.updates;
  return DividedUp(config.total_steps(),
                   static_cast<std::uint64_t>(config.collection().episodes_per_update()));
}

/// The value of --network for actors. Over TCP it is the learner's; peers that are found
/// by UDP are the actors' addresses here, and the learner's there.
std::string NetworkOfActors(const RuntimeConfig& runtime) {
  const bool names_peers = runtime.network() != "loopback" && runtime.network() != "lan";
  if (names_peers && runtime.transport() != "tcp")
    return "<address of " + process::HostName() + ">";
  return runtime.network();
}

/// The options by which actors and observers find the run.
std::string HowToFind(const RunOptions& options) {
  const RuntimeConfig& runtime = options.config.runtime();
  std::string words;
  if (runtime.domain() != 0) words += " --domain " + std::to_string(runtime.domain());
  if (runtime.transport() != "udp") words += " --transport " + runtime.transport();
  if (runtime.network() != "loopback") words += " --network " + NetworkOfActors(runtime);
  if (!runtime.discovery_server().empty()) {
    words += " --discovery-server " + runtime.discovery_server();
  }
  return words;
}

void SayHowToWatch(const RunOptions& options) {
  const bool secured = !options.config.runtime().security().empty();
  spdlog::info("watch it with: metronome-learner status {}{}{}", options.run, HowToFind(options),
               secured ? " --security DIR/observer" : "");
}

run::CoordinatorSetup SetupOf(const RunOptions& options, const run::RunStart& start) {
  const RunConfig& config = options.config;
  run::CoordinatorSetup setup;
  setup.description.learner_id = process::RandomId();
  setup.description.incarnation = start.checkpoint.incarnation;
  setup.description.run_name = options.run;
  setup.description.engine = process::EngineName();
  setup.description.build =
      kernels::WithCurrentIsa(process::BuildIdentity()) + ", " + HostAndProcess();
  setup.description.config = config.SerializeAsString();
  setup.rules.episodes_per_update =
      static_cast<std::uint64_t>(config.collection().episodes_per_update());
  setup.rules.overlap = static_cast<std::uint64_t>(config.collection().overlap());
  setup.canonical_digest = start.checkpoint.state.canonical_digest;
  setup.rules.first_version = start.checkpoint.state.version;
  setup.rules.updates_total = std::max(MostUpdates(config), setup.rules.first_version);
  setup.total_steps = config.total_steps();
  setup.audit = {config.runtime().audit_share(), process::RandomId()};
  setup.status.task = config.environment().task();
  setup.status.host = process::HostName();
  setup.status.pid = static_cast<std::uint32_t>(getpid());
  setup.status.length = LengthOf(config);
  setup.seconds_before = start.checkpoint.logs.wall_seconds;
  setup.checkpoint_every = static_cast<std::uint64_t>(config.runtime().checkpoint_every());
  setup.milestone_every = static_cast<std::uint64_t>(config.runtime().milestone_every());
  setup.resumed = start.resumed;
  setup.how_to_join = "metronome-actor run --run " + options.run + HowToFind(options);
  if (!config.runtime().security().empty()) setup.how_to_join += " --security DIR/ACTOR";
  return setup;
}

collect::trust::ExcludedHosts ExcludedHostsOf(const std::string& folder) {
  const std::string path = collect::trust::ExcludedHostsPathOf(folder);
  collect::trust::ExcludedHosts hosts = collect::trust::LoadExcludedHosts(path);
  for (const auto& [host, reason] : hosts) {
    spdlog::warn("{}; it stays excluded (to let it in, take it out of {} before the start)", reason,
                 path);
  }
  return hosts;
}

record::RunFacts FactsOf(const RunOptions& options, const run::CoordinatorSetup& setup) {
  record::RunFacts facts;
  facts.run = options.run;
  facts.path = options.folder;
  facts.incarnation = setup.description.incarnation;
  facts.length = setup.status.length;
  facts.episodes_per_update = setup.rules.episodes_per_update;
  facts.domain = options.config.runtime().domain();
  facts.transport = options.config.runtime().transport();
  facts.network = options.config.runtime().network();
  facts.placements =
      config::FieldText(options.config.environment(),
                        *EnvironmentConfig::descriptor()->FindFieldByName("placements"));
  facts.security = options.config.runtime().security();
  facts.discovery_server = options.config.runtime().discovery_server();
  return facts;
}

int ThreadsOf(const RunConfig& config) {
  const int wanted = config.runtime().learner_threads();
  if (wanted == 0) return process::UsableCpus();
  if (const auto warning = process::TooManyThreads(wanted, "--threads"))
    spdlog::warn("{}", *warning);
  return wanted;
}

std::unique_ptr<watch::MetricsServer> MetricsServerOf(const RunConfig& config) {
  const std::string& address = config.runtime().metrics();
  if (address.empty()) return nullptr;
  return std::make_unique<watch::MetricsServer>(text::ParseListenAddress(address));
}

int Serve(const RunOptions& options, const algorithm::Algorithms& algorithms,
          process::StopTarget& target) {
  const algorithm::AlgorithmFactory& factory = algorithm::FactoryOf(algorithms, options.config);
  const BusOptions bus_options = BusOptionsOf(options);
  dds::CheckMachineOfLearner(bus_options);
  record::RunFolder folder(options.folder);
  const auto metrics = MetricsServerOf(options.config);  // a rival has the port, too
  run::RunStart start = run::StartOf(options, factory);
  const std::unique_ptr<algorithm::Algorithm> algorithm =
      run::AlgorithmOf(start, factory, {ThreadsOf(options.config), process::RandomId()});
  start.checkpoint.incarnation = folder.NextIncarnation(start.checkpoint.incarnation);
  start.checkpoint.build = process::BuildIdentity();
  start.checkpoint.isa = kernels::NameOf(kernels::CurrentIsa());
  run::CoordinatorSetup setup = SetupOf(options, start);
  setup.excluded = ExcludedHostsOf(options.folder);
  if (metrics) {
    setup.on_status = [&metrics](const LearnerStatus& status) { metrics->Show(status); };
  }
  process::OutputThread output(STDOUT_FILENO);
  record::FileRunRecord record(
      options.folder, std::move(start.checkpoint), algorithm->Metrics(),
      record::ProgressPrinter(options.progress, FactsOf(options, setup),
                              [&](std::string line) { output.Write(std::move(line)); }));
  const auto bus = dds::MakeDdsLearnerBus(bus_options);
  run::BackgroundThread background("update");
  run::Coordinator coordinator(setup, *bus, *algorithm, record, background);
  target.Set([&coordinator](int signal) { coordinator.RequestStop(signal); });
  SayHowToWatch(options);
  const auto clear = [&target](run::Coordinator*) { target.Set(nullptr); };
  const std::unique_ptr<run::Coordinator, decltype(clear)> set(&coordinator, clear);
  const int status = CodeOfServing([&coordinator] { return coordinator.Run(); });
  spdlog::info("{}", process::CpuTimes::OfProcess().Report());
  return status;
}

}  // namespace

int ServeRun(const RunOptions& options, const algorithm::Algorithms& algorithms) {
  process::SetUpLogging("learner", options.log);
  spdlog::info("{}, {}", kernels::WithCurrentIsa(process::BuildIdentity()), process::EngineName());
  for (const std::string& warning : options.warnings) spdlog::warn("{}", warning);
  process::IgnoreLostReaders();
  process::StopTarget target;
  // Before the bus and the trainer, whose threads must inherit the blocked signals.
  const process::SignalWatch signals([&target](int signal) { target.Signal(signal); });
  return CodeOfStart([&] { return Serve(options, algorithms, target); });
}

}  // namespace metronome::learner
