/// An actor that joins a run like any other and then does not play by the rules: it spoils the
/// episodes that it is asked for (spoil.h), or throws bytes at the learner that are no episodes.
/// Prints a line for each sample that it sent spoiled.
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <memory>
#include <mutex>
#include <random>
#include <string>
#include <utility>

#include "actor/client/actor_client.h"
#include "actor/metaworld/tasks/environments.h"
#include "actor/play/environment_player.h"
#include "common/dds/dds_bus.h"
#include "common/process/build_info.h"
#include "common/process/logging.h"
#include "common/process/process_identity.h"
#include "tests/chaos/spoil.h"
#include "tests/integration/raw_writer.h"

namespace metronome::chaos {
namespace {

constexpr const char* kRawKinds[] = {"truncated", "oversized", "noise"};

/// The bytes of an episode, no more an episode.
test::Bytes Corrupt(const std::string& kind, test::Bytes bytes, std::mt19937_64& random) {
  if (kind == "truncated") {
    bytes.resize(random() % bytes.size());
  } else if (kind == "oversized") {
    bytes.insert(bytes.end(), 300'000, 'x');
  } else {
    const std::size_t header = 24;  // the versions and ids stay: the rest is looked at
    for (std::size_t i = header; i < bytes.size(); ++i) bytes[i] = static_cast<char>(random());
  }
  return bytes;
}

/// A bus that spoils what is sent through it; all else is the real one's. Thread-safe.
class HostileBus final : public ActorBus {
 public:
  HostileBus(const BusOptions& options, std::uint64_t actor_id, const std::string& kind)
      : kind_(kind), bus_(dds::MakeDdsActorBus(options, actor_id)) {
    for (const char* raw : kRawKinds) {
      if (kind != raw) continue;
      raw_ = std::make_unique<test::RawWriter>(options, dds::kEpisodeTopic,
                                               wire::EpisodePubSubType().getName());
    }
    if (!raw_) spoiler_.emplace(kind);
  }

  SendResult Send(EpisodeMessage message) override {
    const std::lock_guard lock(mutex_);
    if (raw_) {
      SendRaw(message);
      return bus_->Send(std::move(message));
    }
    const EpisodeMessage truth = message;
    SendResult result = SendResult::kSent;
    for (EpisodeMessage& spoiled : spoiler_->Spoil(std::move(message))) {
      const bool true_one = SameMessage(spoiled, truth);
      result = bus_->Send(std::move(spoiled));
      if (!true_one && result == SendResult::kSent) Tell();
    }
    return result;
  }

  void Send(const ActorStatus& status) override { bus_->Send(status); }
  std::optional<ActorEvent> Wait(Clock::time_point deadline) override {
    return bus_->Wait(deadline);
  }
  void Wake() override { bus_->Wake(); }
  void Close(std::chrono::milliseconds timeout) override { bus_->Close(timeout); }

 private:
  static bool SameMessage(const EpisodeMessage& a, const EpisodeMessage& b) {
    return a.incarnation == b.incarnation && a.actor_id == b.actor_id && a.episode == b.episode;
  }

  static void Tell() {
    std::printf("sent a spoiled sample\n");
    std::fflush(stdout);
  }

  void SendRaw(const EpisodeMessage& message) {
    if (!raw_->WaitForReader(Clock::now() + std::chrono::seconds(2))) return;
    test::Bytes bytes = test::Encode<wire::EpisodePubSubType>(message);
    if (raw_->Write(Corrupt(kind_, std::move(bytes), random_))) Tell();
  }

  const std::string kind_;
  const std::unique_ptr<ActorBus> bus_;
  std::mutex mutex_;
  std::mt19937_64 random_{1};
  std::unique_ptr<test::RawWriter> raw_;  // of the kinds that are no episodes
  std::optional<Spoiler> spoiler_;        // of the others
};

/// @param host  what it calls its host.
int Run(const BusOptions& options, const std::string& kind, const std::string& host) {
  process::SetUpLogging("hostile-actor", {});
  client::ActorClientOptions client_options;
  client_options.run_name = options.run_name;
  client_options.actor_id = process::RandomId();
  client_options.host = host;
  client_options.pid = static_cast<std::uint32_t>(getpid());
  client_options.engine = process::EngineName();
  client_options.build = process::BuildIdentity();
  HostileBus bus(options, client_options.actor_id, kind);
  const environment::EnvironmentRegistry registry(metaworld::tasks::Environments());
  client::ActorClient client(&bus, play::SetUpWith(registry), client_options);
  return client.Run() == client::ActorEnd::kRefused ? 1 : 0;
}

int Main(int argc, char** argv) {
  CLI::App app("An actor that does not play by the rules");
  BusOptions options;
  std::string kind;
  std::string host;
  std::string network = "loopback";
  std::vector<std::string> kinds = Spoiler::Kinds();
  kinds.insert(kinds.end(), std::begin(kRawKinds), std::end(kRawKinds));
  app.add_option("--run", options.run_name)->required();
  app.add_option("--domain", options.domain);
  app.add_option("--network", network);
  app.add_option("--kind", kind)->required()->check(CLI::IsMember(kinds));
  app.add_option("--host", host, "what it calls its host; hostile-KIND by default");
  CLI11_PARSE(app, argc, argv);
  options.network = ParseNetwork(network);
  return Run(options, kind, host.empty() ? "hostile-" + kind : host);
}

}  // namespace
}  // namespace metronome::chaos

int main(int argc, char** argv) {
  try {
    return metronome::chaos::Main(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hostile_actor: %s\n", error.what());
    return 1;
  }
}
