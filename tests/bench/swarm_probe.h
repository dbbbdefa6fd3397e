#pragma once

#include <cstdint>
#include <vector>

#include "common/messages/bus_options.h"
#include "tests/bench/swarm_bank.h"

/// Costs of the wire alone: the two buses, without learner or client. They fork.
namespace metronome::bench {

struct TransportCost {
  std::uint64_t episodes = 0;
  double wall_seconds = 0;
  double actor_cpu_seconds = 0;    // all threads of the sending process, playing included
  double play_cpu_seconds = 0;     // of these: playing
  double learner_cpu_seconds = 0;  // all threads of the receiving process
};

/// One actor process sends `episodes` episodes to a learner process that drops them.
/// @param plays  whether the actor really plays each one first; else it copies one of those
///               that are prepared in the bank, in turn.
TransportCost MeasureTransport(const BusOptions& options, const EpisodeBank& bank,
                               std::uint64_t episodes, bool plays);

/// Publishes `rounds` snapshots of the bank's size, one at a time, to `actors` actor processes.
/// @return [rounds] milliseconds from Publish until the last actor had it.
std::vector<double> MeasureWeights(const BusOptions& options, const EpisodeBank& bank,
                                   std::uint64_t actors, std::uint64_t rounds);

}  // namespace metronome::bench
