// To be preloaded into a learner: says how many connections are open when Fast DDS 2.9 begins to
// take its TCP receivers down. Two are enough to spoil the heap
// (common/dds/workarounds/tcp_connections.h, EndConnections).
#include <dlfcn.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <iostream>

#define CLOSE_INPUT_CHANNEL                                                       \
  "_ZN8eprosima7fastdds4rtps21TCPTransportInterface17CloseInputChannelERKNS_8fas" \
  "trtps4rtps9Locator_tE"

namespace {

bool IsTcpConnection(int descriptor) {
  sockaddr_in peer{};
  socklen_t size = sizeof peer;
  if (getpeername(descriptor, reinterpret_cast<sockaddr*>(&peer), &size) != 0) return false;
  int type = 0;
  size = sizeof type;
  return peer.sin_family == AF_INET &&
         getsockopt(descriptor, SOL_SOCKET, SO_TYPE, &type, &size) == 0 && type == SOCK_STREAM;
}

int Connections() {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  int connections = 0;
  for (int descriptor = 0; descriptor < static_cast<int>(limit.rlim_cur); ++descriptor) {
    if (IsTcpConnection(descriptor)) ++connections;
  }
  return connections;
}

}  // namespace

bool CloseInputChannel(void* transport, const void* locator) __asm__(CLOSE_INPUT_CHANNEL);

bool CloseInputChannel(void* transport, const void* locator) {
  static const auto real =
      reinterpret_cast<decltype(&CloseInputChannel)>(dlsym(RTLD_NEXT, CLOSE_INPUT_CHANNEL));
  std::cerr << "connections at the end: " << Connections() << std::endl;
  return real(transport, locator);
}
