#include "common/dds/machine.h"

#include <ifaddrs.h>
#include <net/if.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include <memory>
#include <stdexcept>
#include <string>

#include "common/dds/shared_memory.h"

namespace metronome::dds {
namespace {

constexpr const char* kRemedy = "ip link set lo up (as root)";

/// Whether an interface has an IPv4 address and all of `flags`, and is loopback or not as asked;
/// also if that cannot be known.
bool IsThere(unsigned flags, bool loopback) {
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return true;
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> all(first, freeifaddrs);
  for (const ifaddrs* one = first; one != nullptr; one = one->ifa_next) {
    const bool is_asked_for =
        (one->ifa_flags & flags) == flags && ((one->ifa_flags & IFF_LOOPBACK) != 0) == loopback;
    if (is_asked_for && one->ifa_addr != nullptr && one->ifa_addr->sa_family == AF_INET) {
      return true;
    }
  }
  return false;
}

}  // namespace

void CheckLoopback(const Network& network) {
  if (network.scope != Network::Scope::kLoopback || IsThere(IFF_UP, true)) return;
  throw std::invalid_argument(
      std::string("the loopback interface is down, and network loopback needs it: ") + kRemedy);
}

void WarnOfInterfaces(const Network& network) {
  if (network.scope == Network::Scope::kLoopback) return;
  if (!IsThere(IFF_UP, true)) {
    spdlog::warn(
        "the loopback interface is down: processes of this machine do not reach each other; {}",
        kRemedy);
  }
  if (!IsThere(IFF_RUNNING, false)) {
    spdlog::warn(
        "no interface to a network is up: this process can be found on this machine alone, also "
        "later; start it again once the network is up");
  }
}

void CheckMachineOfLearner(const BusOptions& options) {
  CheckLoopback(options.network);
  if (options.transport != Transport::kSharedMemory) return;
  const SharedMemoryNote asks(options.run_name, options.domain, "learner", true);
}

}  // namespace metronome::dds
