#include "tests/bench/swarm_probe.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>
#include <variant>

#include "actor/play/rollout.h"
#include "common/dds/dds_bus.h"
#include "tests/bench/swarm_process.h"

namespace metronome::bench {
namespace {

constexpr std::uint64_t kActorId = 1;
constexpr std::uint64_t kWarmUp = 40;  // episodes: histories and buffers have grown by then
constexpr std::chrono::seconds kPatience{30};
constexpr std::chrono::milliseconds kAsk{50};

/// The next event of one kind, others being dropped. @throws std::runtime_error after `kPatience`.
template <class Event, class Bus>
Event Next(Bus& bus) {
  const auto deadline = Clock::now() + kPatience;
  while (auto event = bus.Wait(deadline)) {
    if (auto* wanted = std::get_if<Event>(&*event)) return std::move(*wanted);
  }
  throw std::runtime_error("the other end does not answer");
}

/// Says hello until an assignment shows that both ends see each other.
void JoinAsActor(ActorBus& bus) {
  for (auto deadline = Clock::now() + kPatience; Clock::now() < deadline;) {
    ActorStatus status;
    status.actor_id = kActorId;
    status.envs = 1;
    bus.Send(status);
    const auto event = bus.Wait(Clock::now() + kAsk);
    if (event && std::holds_alternative<EpisodeAssignment>(*event)) return;
  }
  throw std::runtime_error("no learner answers");
}

void WelcomeActor(LearnerBus& bus) {
  EpisodeAssignment assignment;
  assignment.actor_id = kActorId;
  do {
    Next<ActorStatus>(bus);
  } while (!bus.Send(assignment));
}

/// Where the sending process gets its episodes.
class Source {
 public:
  Source(const EpisodeBank& bank, bool plays) : bank_(bank) {
    if (!plays) return;
    environment_ = Registry().Make(bank.config().environment());
  }

  EpisodeMessage Next(std::uint64_t number) {
    EpisodeMessage message;
    message.actor_id = kActorId;
    const double begin = ThreadSeconds();
    message.episode = environment_ ? *play::PlayEpisode(bank_.config(), bank_.untrained(), number,
                                                        *environment_, cancel_)
                                   : bank_.Make(number % bank_.prepared(), bank_.untrained());
    play_seconds_ += ThreadSeconds() - begin;
    return message;
  }

  [[nodiscard]] double play_seconds() const { return play_seconds_; }

 private:
  const EpisodeBank& bank_;
  const std::atomic<bool> cancel_{false};
  std::unique_ptr<environment::Environment> environment_;
  double play_seconds_ = 0;
};

/// An assignment may be here before all of the learner's endpoints are known: until they are, no
/// learner is there to send to.
void SendFirstEpisode(ActorBus& bus, Source& source) {
  for (auto deadline = Clock::now() + kPatience; Clock::now() < deadline;) {
    if (bus.Send(source.Next(0)) == ActorBus::SendResult::kSent) return;
    (void)bus.Wait(Clock::now() + kAsk);
  }
  throw std::runtime_error("no learner takes episodes");
}

void SendEpisodes(ActorBus& bus, Source& source, std::uint64_t count) {
  for (std::uint64_t number = 0; number < count; ++number) {
    if (bus.Send(source.Next(number)) != ActorBus::SendResult::kSent) {
      throw std::runtime_error("the learner is gone");
    }
  }
}

void ActAsActor(const BusOptions& options, const EpisodeBank& bank, std::uint64_t episodes,
                bool plays, Pipe& results) {
  Source source(bank, plays);
  const auto bus = dds::MakeDdsActorBus(options, kActorId);
  JoinAsActor(*bus);
  SendFirstEpisode(*bus, source);
  SendEpisodes(*bus, source, kWarmUp - 1);
  Next<EpisodeAssignment>(*bus);
  TransportCost cost;
  const double cpu = ProcessSeconds();
  const double play = source.play_seconds();
  SendEpisodes(*bus, source, episodes);
  bus->Close(kPatience);
  cost.actor_cpu_seconds = ProcessSeconds() - cpu;
  cost.play_cpu_seconds = source.play_seconds() - play;
  results.Write(cost);
  Next<LearnerLost>(*bus);
}

void TakeEpisodes(LearnerBus& bus, std::uint64_t count) {
  for (std::uint64_t i = 0; i < count; ++i) Next<EpisodeMessage>(bus);
}

struct Arrival {
  std::uint64_t version = 0;
  Clock::time_point at;  // the same clock in all processes of a machine
};

void AwaitWeights(const BusOptions& options, std::uint64_t actor_id, std::uint64_t last,
                  Pipe& arrivals) {
  const auto bus = dds::MakeDdsActorBus(options, actor_id);
  for (Arrival arrival; arrival.version < last;) {
    arrival.version = Next<PolicySnapshot>(*bus).version;
    arrival.at = Clock::now();
    arrivals.Write(arrival);
  }
}

/// When the last of `actors` actors has `version`.
Clock::time_point LastArrival(Pipe& arrivals, std::uint64_t actors, std::uint64_t version) {
  Clock::time_point last{};
  for (std::uint64_t missing = actors; missing > 0;) {
    const auto arrival = arrivals.Read<Arrival>();
    if (arrival.version != version) continue;
    last = std::max(last, arrival.at);
    --missing;
  }
  return last;
}

}  // namespace

TransportCost MeasureTransport(const BusOptions& options, const EpisodeBank& bank,
                               std::uint64_t episodes, bool plays) {
  Pipe results;
  const int actor = Fork([&] { ActAsActor(options, bank, episodes, plays, results); });
  TransportCost cost;
  {
    const auto bus = dds::MakeDdsLearnerBus(options);
    bus->Publish(RunDescription{});
    WelcomeActor(*bus);
    TakeEpisodes(*bus, kWarmUp);
    EpisodeAssignment go;
    go.actor_id = kActorId;
    bus->Send(go);
    const double cpu = ProcessSeconds();
    const auto begin = Clock::now();
    TakeEpisodes(*bus, episodes);
    const double wall = std::chrono::duration<double>(Clock::now() - begin).count();
    cost = results.Read<TransportCost>();
    cost.learner_cpu_seconds = ProcessSeconds() - cpu;
    cost.wall_seconds = wall;
    cost.episodes = episodes;
  }
  WaitForAll({actor});
  return cost;
}

std::vector<double> MeasureWeights(const BusOptions& options, const EpisodeBank& bank,
                                   std::uint64_t actors, std::uint64_t rounds) {
  Pipe arrivals;
  std::vector<int> children;
  for (std::uint64_t i = 0; i < actors; ++i) {
    children.push_back(Fork([&, i] { AwaitWeights(options, i + 1, rounds, arrivals); }));
  }
  std::vector<double> milliseconds;
  {
    const auto bus = dds::MakeDdsLearnerBus(options);
    PolicySnapshot snapshot = bank.untrained();
    for (snapshot.version = 0; snapshot.version <= rounds; ++snapshot.version) {
      const auto begin = Clock::now();
      bus->Publish(snapshot);
      const auto end = LastArrival(arrivals, actors, snapshot.version);
      // The first one waits for discovery.
      if (snapshot.version == 0) continue;
      milliseconds.push_back(std::chrono::duration<double, std::milli>(end - begin).count());
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    WaitForAll(children);
  }
  return milliseconds;
}

}  // namespace metronome::bench
