#include "common/dds/workarounds/tcp_connections.h"

#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace metronome::dds::workarounds {
namespace {

constexpr std::chrono::milliseconds kMuteFor{300};
constexpr std::chrono::milliseconds kMutePoll{5};
constexpr std::chrono::seconds kEndFor{5};
constexpr std::chrono::milliseconds kEndPoll{2};

std::optional<int> NumberOf(const std::filesystem::path& descriptor) {
  const std::string name = descriptor.filename();
  int number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  return error == std::errc{} ? std::optional(number) : std::nullopt;
}

/// This process's open descriptors; none if there is no descriptor left to list them by.
std::vector<int> Descriptors() {
  std::vector<int> descriptors;
  std::error_code error;  // destructors list them too, and must not throw
  for (std::filesystem::directory_iterator entry("/proc/self/fd", error), end; entry != end;
       entry.increment(error)) {
    if (const auto descriptor = NumberOf(entry->path())) descriptors.push_back(*descriptor);
  }
  return descriptors;
}

/// @param end  getsockname: our end's port; getpeername: the other's. @return std::nullopt if the
/// descriptor is no IPv4 socket or has no such end.
std::optional<std::uint16_t> PortOf(int descriptor, decltype(&getsockname) end) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  if (end(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0 ||
      address.sin_family != AF_INET) {
    return std::nullopt;
  }
  return ntohs(address.sin_port);
}

bool ListensOn(int descriptor, std::uint16_t port) {
  int listens = 0;
  socklen_t size = sizeof listens;
  return getsockopt(descriptor, SOL_SOCKET, SO_ACCEPTCONN, &listens, &size) == 0 && listens != 0 &&
         PortOf(descriptor, getsockname) == port;
}

bool IsConnectedTo(int descriptor, std::uint16_t port) {
  return PortOf(descriptor, getpeername) == port;
}

/// The socket that a descriptor stands for, under a name that no other open one has; std::nullopt
/// if it was closed meanwhile.
std::optional<std::string> SocketOf(int descriptor) {
  std::error_code error;
  const auto target =
      std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(descriptor), error);
  return error ? std::nullopt : std::optional(target.string());
}

/// Whether something came in answer to our first message and we said nothing since.
bool IsMute(int descriptor) {
  tcp_info info{};
  socklen_t size = sizeof info;
  return getsockopt(descriptor, IPPROTO_TCP, TCP_INFO, &info, &size) == 0 &&
         info.tcpi_bytes_received > 0 && info.tcpi_data_segs_out <= 1;
}

/// @return true if it stays mute for longer than Fast DDS takes to go on.
bool StaysMute(int descriptor) {
  const auto deadline = std::chrono::steady_clock::now() + kMuteFor;
  while (IsMute(descriptor)) {
    if (std::chrono::steady_clock::now() >= deadline) return true;
    std::this_thread::sleep_for(kMutePoll);
  }
  return false;
}

}  // namespace

void EndSilentConnections(std::uint16_t port, std::chrono::milliseconds lease) {
  bool found = false;
  for (const int descriptor : Descriptors()) {
    if (!ListensOn(descriptor, port)) continue;
    found = true;
    // Connections inherit it from the socket that accepts them.
    const auto milliseconds = static_cast<unsigned int>(lease.count());
    if (setsockopt(descriptor, IPPROTO_TCP, TCP_USER_TIMEOUT, &milliseconds, sizeof milliseconds) !=
        0) {
      throw std::runtime_error("TCP port " + std::to_string(port) +
                               ": no time-out can be set for its connections");
    }
  }
  if (found) return;
  throw std::runtime_error(
      "TCP port " + std::to_string(port) +
      " cannot be listened on: another learner of this machine and domain may have it; choose "
      "another, for the actors too: --network HOST:PORT");
}

void CutMuteConnections(std::uint16_t port) {
  for (const int descriptor : Descriptors()) {
    if (IsConnectedTo(descriptor, port) && StaysMute(descriptor)) shutdown(descriptor, SHUT_RDWR);
  }
}

void EndConnections(std::uint16_t port) {
  for (const int descriptor : Descriptors()) {
    if (ListensOn(descriptor, port)) shutdown(descriptor, SHUT_RDWR);  // nobody else comes in
  }
  std::vector<std::pair<int, std::string>> ended;
  for (const int descriptor : Descriptors()) {
    const bool is_accepted =
        PortOf(descriptor, getsockname) == port && PortOf(descriptor, getpeername);
    if (!is_accepted && !IsConnectedTo(descriptor, port)) continue;
    if (const auto socket = SocketOf(descriptor)) ended.emplace_back(descriptor, *socket);
    shutdown(descriptor, SHUT_RDWR);
  }
  // The thread that reads a socket closes it when it is done with what came last.
  const auto is_open = [](const auto& socket) { return SocketOf(socket.first) == socket.second; };
  const auto deadline = std::chrono::steady_clock::now() + kEndFor;
  while (std::any_of(ended.begin(), ended.end(), is_open) &&
         std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(kEndPoll);
  }
}

}  // namespace metronome::dds::workarounds
