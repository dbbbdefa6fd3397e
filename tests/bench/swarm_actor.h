#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "common/messages/bus.h"
#include "common/messages/bus_options.h"
#include "tests/bench/swarm_bank.h"

namespace metronome::bench {

/// An actor that speaks the real protocol and answers every assignment from a bank, in the order
/// they come, as fast as the learner takes them. One thread; not thread-safe.
class SimulatedActor {
 public:
  /// @param envs  announced to the learner, which assigns two episodes an env.
  /// @param bank   must outlive the actor.
  SimulatedActor(const BusOptions& bus, std::uint64_t actor_id, std::uint32_t envs,
                 const EpisodeBank& bank);

  /// Blocks until the run is finished or its learner is gone.
  void Run();

 private:
  void Handle(ActorEvent& event);
  void SendStatus();
  void AnswerReady();
  void Answer(std::uint64_t number, const PolicySnapshot& snapshot);

  const std::uint64_t actor_id_;
  const std::uint32_t envs_;
  const EpisodeBank& bank_;
  const std::unique_ptr<ActorBus> bus_;
  std::optional<RunDescription> learner_;
  std::map<std::uint64_t, PolicySnapshot> snapshots_;  // by version, the latest few
  std::vector<EpisodeAssignment> waiting_;             // for their snapshot
  std::uint64_t sent_ = 0;
  Clock::time_point next_status_;
  bool over_ = false;
};

}  // namespace metronome::bench
