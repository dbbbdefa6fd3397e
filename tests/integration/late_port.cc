// To be preloaded into an actor: holds the thread that connects up, once, before it notes which
// port it wants inside the connection, so that the learner's greeting is there first
// (common/dds/workarounds/tcp_connections.h, CutMuteConnections). It stands before a function of
// Fast DDS 2.9's; it says so when it is called.
#include <dlfcn.h>

#include <atomic>
#include <chrono>
#include <iostream>
#include <thread>

#define CONNECT                                                             \
  "_ZN8eprosima7fastdds4rtps23TCPChannelResourceBasic7connectERKSt10shared" \
  "_ptrINS1_18TCPChannelResourceEE"

void Connect(void* channel, const void* itself) __asm__(CONNECT);

void Connect(void* channel, const void* itself) {
  static const auto real = reinterpret_cast<decltype(&Connect)>(dlsym(RTLD_NEXT, CONNECT));
  real(channel, itself);
  static std::atomic<bool> first{true};
  if (!first.exchange(false)) return;
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  std::cerr << "held up between connecting and noting the port" << std::endl;
}
