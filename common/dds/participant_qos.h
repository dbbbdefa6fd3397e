#pragma once

#include <fastrtps/rtps/common/Time_t.h>

#include <cstdint>
#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <string>

#include "common/messages/bus_options.h"

namespace metronome::dds {

inline constexpr const char* kActorRole = "actor";        // finds learners alone, not other actors
inline constexpr const char* kObserverRole = "observer";  // likewise
bool FindsLearnersAlone(const std::string& role);

/// A peer that is not heard for so long is gone.
inline constexpr std::uint32_t kLeaseMilliseconds = 2500;
inline const eprosima::fastrtps::Duration_t kLease{kLeaseMilliseconds / 1000,
                                                   kLeaseMilliseconds % 1000 * 1'000'000};
/// Between two words of a peer: leaves room for starved threads.
inline const eprosima::fastrtps::Duration_t kAnnouncement{0, 500'000'000};

inline constexpr const char* kLoopbackAddress = "127.0.0.1";
inline constexpr std::uint32_t kSocketBufferBytes = 4 << 20;

/// Transports, discovery and leases of a participant, as the options ask.
/// @param role  "learner", kActorRole or kObserverRole: shown by DDS tools as "metronome-learner
/// RUN".
eprosima::fastdds::dds::DomainParticipantQos ParticipantQos(const BusOptions& options,
                                                            const std::string& role);

}  // namespace metronome::dds
