#pragma once

#include <map>
#include <thread>
#include <vector>

#include "common/dds/workarounds/lease_race_guard.h"
#include "common/messages/bus_options.h"
#include "common/process/mutex.h"

namespace metronome::dds::workarounds {

/// Two things that a participant needs to outlive its Discovery Servers, and that Fast DDS 2.9
/// does not do. Thread-safe; must outlive the participant whose listener it is.
///
/// - Clients leave it to the servers to notice that a peer is gone, so without a server nobody
///   does. Here each peer's lease is looked at as without servers. (Peers speak twice a second:
///   Participant::MakeWriter.)
/// - A server that is killed and started again begins to count its messages anew, and a client that
///   has not noticed takes the first ones for known: it does not hear of newcomers. Here the
///   server's port is probed; as soon as its system answers that nobody is there, the server is
///   dropped, and all is read again once it is back. Where no such answer comes (a firewall, a
///   whole machine gone), the server's own lease must have run out before it is started again.
class DiscoveryClient final : public LeaseRaceGuard {
 public:
  /// @param probes  for the participant that newcomers look for: the learner's. Others join anew
  ///                when they have lost the learner.
  /// @throws std::system_error if there is no socket or thread to probe with.
  DiscoveryClient(const std::vector<Network::Peer>& servers, bool probes);
  ~DiscoveryClient() override { Stop(); }
  DiscoveryClient(const DiscoveryClient&) = delete;
  DiscoveryClient& operator=(const DiscoveryClient&) = delete;

  /// To be called before the participant is deleted, by the thread that made this.
  void Stop();

  void on_participant_discovery(eprosima::fastdds::dds::DomainParticipant* participant,
                                Discovered&& discovered) override;

 private:
  using Prefix = eprosima::fastrtps::rtps::GuidPrefix_t;

  void OpenProbes();
  void CloseProbes();
  void Probe();
  void Drop(const Prefix& server);

  std::map<Prefix, Network::Peer> addresses_;
  process::Mutex mutex_;
  std::map<Prefix, Proxy*> servers_ METRONOME_GUARDED_BY(mutex_);  // those that are known now
  std::map<Prefix, int> probes_;                                   // a socket a server
  int stop_ = -1;                                                  // an eventfd
  std::thread thread_;
};

}  // namespace metronome::dds::workarounds
