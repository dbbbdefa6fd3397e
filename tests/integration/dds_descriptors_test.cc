// With no file descriptor left.

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <system_error>

#include "common/dds/dds_bus.h"
#include "common/dds/workarounds/discovery_client.h"
#include "tests/integration/dds_fixture.h"

namespace metronome::test {
namespace {

/// While it lives, descriptors from `first` on cannot be opened.
class DescriptorLimit {
 public:
  explicit DescriptorLimit(int first) {
    EXPECT_EQ(getrlimit(RLIMIT_NOFILE, &before_), 0);
    const rlimit limit{static_cast<rlim_t>(first), before_.rlim_max};
    EXPECT_EQ(setrlimit(RLIMIT_NOFILE, &limit), 0);
  }
  ~DescriptorLimit() { EXPECT_EQ(setrlimit(RLIMIT_NOFILE, &before_), 0); }
  DescriptorLimit(const DescriptorLimit&) = delete;
  DescriptorLimit& operator=(const DescriptorLimit&) = delete;

 private:
  rlimit before_{};
};

/// The descriptor that is opened next.
int NextDescriptor() {
  const int next = dup(STDERR_FILENO);
  close(next);
  return next;
}

TEST(DdsDescriptorsTest, WithoutASocketToProbeByADiscoveryClientIsAnErrorAndLeavesNothingOpen) {
  Network::Peer server;
  server.address = "127.0.0.1";
  server.port = 11811;
  const int next = NextDescriptor();
  {
    const DescriptorLimit room_for_one(next + 1);
    EXPECT_THROW(dds::workarounds::DiscoveryClient({server}, true), std::system_error);
  }
  EXPECT_EQ(NextDescriptor(), next);
}

TEST(DdsDescriptorsTest, ALearnerOverTcpEnds) {
  auto learner = dds::MakeDdsLearnerBus(FreshRun(Transport::kTcp));
  const DescriptorLimit none(0);
  learner.reset();  // it looks its connections up, and must not throw
}

}  // namespace
}  // namespace metronome::test
