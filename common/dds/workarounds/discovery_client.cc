#include "common/dds/workarounds/discovery_client.h"

#include <arpa/inet.h>
#include <fastdds/rtps/attributes/ServerAttributes.h>
#include <fastdds/rtps/resources/TimedEvent.h>
#include <netinet/in.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace metronome::dds::workarounds {
namespace {

// Shorter than a server takes to start.
constexpr int kProbeMilliseconds = 20;

/// Fails while there is no route to the peer.
void Connect(int probe, const Network::Peer& peer) {
  sockaddr_in end{};
  end.sin_family = AF_INET;
  end.sin_port = htons(peer.port);
  inet_pton(AF_INET, peer.address.c_str(), &end.sin_addr);
  (void)connect(probe, reinterpret_cast<const sockaddr*>(&end), sizeof end);
}

/// A UDP socket that hears when nobody listens at the address.
int ConnectedSocket(const Network::Peer& peer) {
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (probe < 0) throw std::system_error(errno, std::generic_category(), "probe of a server");
  Connect(probe, peer);
  return probe;
}

/// Sends an empty datagram, which a server's receiving thread passes over. @return whether an
/// earlier one was answered by the system that nobody listens there.
bool IsRefused(int probe, const Network::Peer& peer) {
  if (send(probe, nullptr, 0, 0) == 0) return false;
  if (errno == EDESTADDRREQ || errno == ENOTCONN) Connect(probe, peer);
  return errno == ECONNREFUSED;
}

}  // namespace

DiscoveryClient::DiscoveryClient(const std::vector<Network::Peer>& servers, bool probes) {
  int id = 0;
  for (const Network::Peer& peer : servers) {
    Prefix prefix;
    eprosima::fastrtps::rtps::get_server_client_default_guidPrefix(id++, prefix);
    addresses_.emplace(prefix, peer);
  }
  if (!probes) return;
  try {
    OpenProbes();
    thread_ = std::thread([this] { Probe(); });
  } catch (...) {
    CloseProbes();
    throw;
  }
}

// Not by the thread: what it threw would end the process.
void DiscoveryClient::OpenProbes() {
  stop_ = eventfd(0, EFD_CLOEXEC);
  if (stop_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
  for (const auto& [prefix, peer] : addresses_) probes_.emplace(prefix, ConnectedSocket(peer));
}

void DiscoveryClient::CloseProbes() {
  for (const auto& [prefix, probe] : probes_) close(probe);
  if (stop_ >= 0) close(stop_);
}

void DiscoveryClient::Stop() {
  if (!thread_.joinable()) return;
  eventfd_write(stop_, 1);
  thread_.join();
  CloseProbes();
}

void DiscoveryClient::on_participant_discovery(
    eprosima::fastdds::dds::DomainParticipant* participant, Discovered&& discovered) {
  Proxy& proxy = ProxyOf(discovered);
  const Prefix& prefix = proxy.m_guid.guidPrefix;
  if (addresses_.count(prefix) > 0) {
    const process::MutexLock lock(mutex_);
    if (IsGone(discovered)) {
      servers_.erase(prefix);
    } else {
      servers_[prefix] = &proxy;
    }
  } else if (discovered.status == Discovered::DISCOVERED_PARTICIPANT) {
    proxy.should_check_lease_duration = true;
    proxy.lease_duration_event->update_interval(proxy.m_leaseDuration);
    proxy.lease_duration_event->restart_timer();
  }
  LeaseRaceGuard::on_participant_discovery(participant, std::move(discovered));
}

void DiscoveryClient::Probe() {
  pollfd stop{stop_, POLLIN, 0};
  do {
    for (const auto& [prefix, probe] : probes_) {
      if (IsRefused(probe, addresses_.at(prefix))) Drop(prefix);
    }
  } while (poll(&stop, 1, kProbeMilliseconds) == 0);
}

void DiscoveryClient::Drop(const Prefix& server) {
  const process::MutexLock lock(mutex_);
  const auto known = servers_.find(server);
  if (known == servers_.end()) return;
  spdlog::warn(
      "the discovery server at {}:{} is gone: what runs goes on, newcomers wait for its return",
      addresses_.at(server).address, addresses_.at(server).port);
  // Its lease is over, now.
  Proxy& proxy = *known->second;
  proxy.m_leaseDuration = eprosima::fastrtps::Duration_t{0, 0};
  proxy.lease_duration_event->cancel_timer();
  proxy.lease_duration_event->update_interval_millisec(1);
  proxy.lease_duration_event->restart_timer();
  servers_.erase(known);
}

}  // namespace metronome::dds::workarounds
