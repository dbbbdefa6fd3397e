#pragma once

#include "common/messages/bus_options.h"

/// The needs of a participant: loopback, shared memory, a network.
namespace metronome::dds {

/// To be called before anything of a run is made, so that none is started half; the bus asks again
/// when it is made.
/// @throws std::invalid_argument that names what is missing and the remedy: the loopback interface,
///         or shared memory for the learner and an actor.
void CheckMachineOfLearner(const BusOptions& options);

/// @throws std::invalid_argument, with the remedy, if the network is loopback and it is down.
void CheckLoopback(const Network& network);

/// Of interfaces that are down, on a network: Fast DDS takes a participant's addresses once, when
/// it is made.
void WarnOfInterfaces(const Network& network);

}  // namespace metronome::dds
