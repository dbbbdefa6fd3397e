#pragma once

#include <cstdint>
#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <string>

#include "common/dds/bus_options.h"

namespace metronome::dds {

inline constexpr const char* kActorRole = "actor";        // finds learners alone, not other actors
inline constexpr const char* kObserverRole = "observer";  // likewise
bool FindsLearnersAlone(const std::string& role);

/// A peer that is not heard for so long is gone.
inline constexpr std::uint32_t kLeaseMilliseconds = 2500;

/// Transports, discovery and leases of a participant, as the options ask.
/// @param role  "learner", kActorRole or kObserverRole: shown by DDS tools as "metronome-learner
/// RUN".
eprosima::fastdds::dds::DomainParticipantQos ParticipantQos(const BusOptions& options,
                                                            const std::string& role);

}  // namespace metronome::dds
