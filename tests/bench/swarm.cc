/// Simulated actors that speak the real protocol (`actors`), and the cost of the wire alone
/// (`transport`, `weights`). Each command prints one JSON object.
#include <CLI/CLI.hpp>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/process/logging.h"
#include "tests/bench/swarm_actor.h"
#include "tests/bench/swarm_bank.h"
#include "tests/bench/swarm_probe.h"
#include "tests/bench/swarm_process.h"

namespace metronome::bench {
namespace {

struct Options {
  std::string config_file;  // of `metronome-learner config`
  std::string run = "swarm";
  std::uint32_t domain = 0;
  std::string transport = "udp";
  std::uint64_t recordings = 4;
  std::uint64_t prepared = 256;
  std::uint64_t actors = 1;
  std::uint32_t envs = 1;
  std::uint64_t episodes = 1000;
  std::uint64_t rounds = 50;
  bool plays = false;
};

BusOptions BusOf(const Options& options) {
  BusOptions bus;
  bus.run_name = options.run;
  bus.domain = options.domain;
  bus.transport = ParseTransport(options.transport);
  return bus;
}

EpisodeBank BankOf(const Options& options) {
  config::ConfigDraft draft;
  draft.ReadFile(options.config_file);
  return EpisodeBank(draft.Finish([](const auto& name) { return Registry().Describe(name); }),
                     options.recordings, options.prepared);
}

nlohmann::json RunActors(const Options& options) {
  const EpisodeBank bank = BankOf(options);
  Pipe made;
  std::vector<int> children;
  for (std::uint64_t i = 0; i < options.actors; ++i) {
    children.push_back(Fork([&, i] {
      SimulatedActor actor(BusOf(options), i + 1, options.envs, bank);
      made.Write('.');
      actor.Run();
    }));
  }
  // A learner that starts now does not wait for bank or processes.
  for (std::uint64_t i = 0; i < options.actors; ++i) made.Read<char>();
  std::cout << "ready" << std::endl;
  return {{"cpu_seconds", WaitForAll(children)}};
}

nlohmann::json RunTransport(const Options& options) {
  const TransportCost cost =
      MeasureTransport(BusOf(options), BankOf(options), options.episodes, options.plays);
  return {{"episodes", cost.episodes},
          {"wall_seconds", cost.wall_seconds},
          {"actor_cpu_seconds", cost.actor_cpu_seconds},
          {"play_cpu_seconds", cost.play_cpu_seconds},
          {"learner_cpu_seconds", cost.learner_cpu_seconds}};
}

nlohmann::json RunWeights(const Options& options) {
  return {{"milliseconds",
           MeasureWeights(BusOf(options), BankOf(options), options.actors, options.rounds)}};
}

CLI::App* AddCommand(CLI::App& app, Options& options, const char* name, const char* help) {
  CLI::App* command = app.add_subcommand(name, help);
  command->add_option("--config", options.config_file, "resolved configuration")->required();
  command->add_option("--run", options.run, "name of the run");
  command->add_option("--domain", options.domain, "DDS domain");
  command->add_option("--transport", options.transport, "udp or shm");
  return command;
}

int Main(int argc, char** argv) {
  CLI::App app("Simulated actors, and the cost of the wire");
  app.require_subcommand(1);
  Options options;
  CLI::App* actors = AddCommand(
      app, options, "actors", "actor processes that answer from a bank; says when they are ready");
  actors->add_option("--actors", options.actors, "processes");
  actors->add_option("--envs", options.envs, "that each of them announces");
  actors->add_option("--recordings", options.recordings, "episodes really played");
  actors->add_option("--prepared", options.prepared, "numbers worked out under version 0");
  CLI::App* transport = AddCommand(app, options, "transport", "processor time per episode");
  transport->add_option("--episodes", options.episodes, "to send");
  transport->add_flag("--plays", options.plays, "play each episode first");
  CLI::App* weights = AddCommand(app, options, "weights", "latency of weights to actors");
  weights->add_option("--actors", options.actors, "processes");
  weights->add_option("--rounds", options.rounds, "snapshots to publish");
  CLI11_PARSE(app, argc, argv);
  const auto run = actors->parsed() ? RunActors : transport->parsed() ? RunTransport : RunWeights;
  std::cout << run(options) << std::endl;
  return 0;
}

}  // namespace
}  // namespace metronome::bench

int main(int argc, char** argv) {
  try {
    metronome::process::SetUpLogging("swarm", {});
    return metronome::bench::Main(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "swarm: %s\n", error.what());
    return 1;
  }
}
