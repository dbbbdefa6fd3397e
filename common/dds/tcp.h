#pragma once

#include <cstdint>
#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>

#include "common/messages/bus_options.h"

/// TCP as Metronome uses it: the learner listens on one port, all others connect to it and listen
/// nowhere, so that they may sit behind firewalls and address translation.
namespace metronome::dds {

/// The port that the learner listens on: of --network HOST:PORT, else 7410 + 250 * domain, the
/// number that discovery has on UDP.
std::uint16_t TcpPort(const BusOptions& options);

/// Transport, addresses and whom to look for. Looks up the route to the learner (no packet is
/// sent).
void AddTcp(const BusOptions& options, bool is_learner,
            eprosima::fastdds::dds::DomainParticipantQos* qos);

}  // namespace metronome::dds
