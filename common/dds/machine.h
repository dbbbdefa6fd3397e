#pragma once

#include <string>

#include "common/dds/bus_options.h"

/// What a participant needs of this machine.
namespace metronome {

/// To be called before anything of a run is made, so that none is started half. The bus asks again
/// when it is made.
/// @param role  "learner", "actor" or "observer".
/// @throws std::invalid_argument that names what is missing and the remedy: the loopback
///         interface, or shared memory.
void CheckMachine(const BusOptions& options, const std::string& role);

namespace dds {

/// @throws std::invalid_argument, with the remedy, if the network is loopback and it is down.
void CheckLoopback(const Network& network);

/// Of interfaces that are down, on a network: Fast DDS takes a participant's addresses once, when
/// it is made.
void WarnOfInterfaces(const Network& network);

}  // namespace dds
}  // namespace metronome
