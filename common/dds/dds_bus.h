#pragma once

#include <cstdint>
#include <memory>

#include "common/messages/bus.h"
#include "common/messages/bus_options.h"

/// The wire: common/messages/bus.h over Fast DDS. One participant per bus, and one bus per process
/// (two in one process work, over the transport like strangers; tests do that).
///
/// Samples that cannot be right come out as BadSample, whatever bytes they hold. Exceptions to
/// that: an ActorStatus or RunDescription of another protocol version comes out as itself, with its
/// protocol_version, incarnation and id alone, so that both ends can refuse by naming both
/// versions.
namespace metronome::dds {

/// @throws std::invalid_argument for bad options and for what this machine lacks (loopback, shared
///         memory), with the remedy; std::runtime_error if Fast DDS will not start.
std::unique_ptr<LearnerBus> MakeDdsLearnerBus(const BusOptions& options);

/// @param actor_id  random per process; assignments for others are filtered out by it.
/// @throws as MakeDdsLearnerBus.
std::unique_ptr<ActorBus> MakeDdsActorBus(const BusOptions& options, std::uint64_t actor_id);

/// @throws as MakeDdsLearnerBus.
std::unique_ptr<ObserverBus> MakeDdsObserverBus(const BusOptions& options);

}  // namespace metronome::dds
