#include "common/dds/discovery_client.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <system_error>

namespace metronome::dds {
namespace {

/// The descriptor that is opened next.
int NextDescriptor() {
  const int next = dup(STDERR_FILENO);
  close(next);
  return next;
}

TEST(DiscoveryClientTest, WithoutASocketToProbeByItIsAnErrorAndLeavesNothingOpen) {
  Network::Peer server;
  server.address = "127.0.0.1";
  server.port = 11811;
  const int next = NextDescriptor();
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit room_for_one{static_cast<rlim_t>(next) + 1, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &room_for_one), 0);
  EXPECT_THROW(DiscoveryClient({server}, true), std::system_error);
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_EQ(NextDescriptor(), next);
}

}  // namespace
}  // namespace metronome::dds
