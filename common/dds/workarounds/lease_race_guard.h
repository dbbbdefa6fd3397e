#pragma once

#include <fastdds/rtps/builtin/data/ParticipantProxyData.h>

#include <fastdds/dds/domain/DomainParticipantListener.hpp>

namespace metronome::dds::workarounds {

using Discovered = eprosima::fastrtps::rtps::ParticipantDiscoveryInfo;

/// Keeps a race inside Debian's Fast DDS from ending the process. A participant that leaves is
/// cleared by the thread that hears it; if its lease is looked at just then by the timers' thread,
/// that one finds it cleared and asserts (PDP::check_remote_participant_liveliness): seen at the
/// end of every other run with 64 actors. The callback comes before the clearing; without the flag
/// the timers' thread looks no further. It is set again whenever the object is used again.
/// Stateless.
class LeaseRaceGuard : public eprosima::fastdds::dds::DomainParticipantListener {
 public:
  using Proxy = eprosima::fastrtps::rtps::ParticipantProxyData;

  void on_participant_discovery(eprosima::fastdds::dds::DomainParticipant* /*participant*/,
                                Discovered&& discovered) override {
    if (IsGone(discovered)) ProxyOf(discovered).should_check_lease_duration = false;
  }

 protected:
  static bool IsGone(const Discovered& discovered) {
    return discovered.status == Discovered::REMOVED_PARTICIPANT ||
           discovered.status == Discovered::DROPPED_PARTICIPANT;
  }

  /// Fast DDS' own record of the participant, not a copy.
  static Proxy& ProxyOf(const Discovered& discovered) {
    return const_cast<Proxy&>(discovered.info);
  }
};

}  // namespace metronome::dds::workarounds
