#include "common/dds/peer_hosts.h"

#include <fastrtps/utils/IPLocator.h>

#include <algorithm>
#include <cstdio>
#include <set>

namespace metronome::dds {
namespace {

namespace rtps = eprosima::fastrtps::rtps;

constexpr const char* kUnknown = "unknown address";

ParticipantKey KeyOf(const rtps::GuidPrefix_t& prefix) {
  ParticipantKey key;
  std::copy(std::begin(prefix.value), std::end(prefix.value), key.begin());
  return key;
}

std::string AddressesOf(const rtps::ParticipantProxyData& participant) {
  std::set<std::string> addresses;
  for (const auto* locators : {&participant.metatraffic_locators, &participant.default_locators}) {
    for (const rtps::Locator_t& locator : locators->unicast) {
      const bool is_ip = locator.kind == LOCATOR_KIND_UDPv4 || locator.kind == LOCATOR_KIND_TCPv4;
      if (is_ip) addresses.insert(rtps::IPLocator::toIPv4string(locator));
    }
  }
  std::string text;
  for (const std::string& address : addresses) text += (text.empty() ? "" : "+") + address;
  return text.empty() ? kUnknown : text;
}

/// 48 bits, of which the first is always 1.
std::string CertificateOf(const ParticipantKey& participant) {
  constexpr std::size_t kOfSubject = 6;
  std::string text = "certificate ";
  for (std::size_t i = 0; i < kOfSubject; ++i) {
    std::array<char, 3> hex{};
    std::snprintf(hex.data(), hex.size(), "%02x", participant[i]);
    text += hex.data();
  }
  return text;
}

}  // namespace

void PeerHosts::Note(const workarounds::Discovered& discovered) {
  const ParticipantKey key = KeyOf(discovered.info.m_guid.guidPrefix);
  const process::MutexLock lock(mutex_);
  if (discovered.status == workarounds::Discovered::DISCOVERED_PARTICIPANT) {
    std::erase(gone_, key);
    hosts_.insert_or_assign(key, AddressesOf(discovered.info));
  } else if (discovered.status != workarounds::Discovered::CHANGED_QOS_PARTICIPANT &&
             hosts_.contains(key)) {
    std::erase(gone_, key);
    gone_.push_back(key);
    if (gone_.size() <= kGoneKept) return;
    hosts_.erase(gone_.front());
    gone_.pop_front();
  }
}

std::string PeerHosts::HostOf(const ParticipantKey& participant) const {
  if (security_) return CertificateOf(participant);
  const process::MutexLock lock(mutex_);
  const auto host = hosts_.find(participant);
  return host == hosts_.end() ? kUnknown : host->second;
}

}  // namespace metronome::dds
