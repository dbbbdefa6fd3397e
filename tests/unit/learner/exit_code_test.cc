#include "learner/exit_code.h"

#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "common/checkpoint/checkpoint.h"
#include "common/config/config.h"
#include "common/process/exit_codes.h"
#include "learner/record/run_folder.h"
#include "learner/run/run_start.h"

namespace metronome {
namespace {

template <class Error>
int Throw() {
  throw Error("what went wrong");
}

struct Case {
  std::function<int()> act;
  int code_of_start;
};

std::vector<Case> Cases() {
  return {{Throw<std::invalid_argument>, kExitUsage},
          {Throw<ConfigError>, kExitUsage},
          {Throw<CannotStart>, kExitUsage},
          {Throw<CheckpointError>, kExitUsage},
          {Throw<CheckpointUnreadable>, kExitFailure},
          {Throw<RunFolderBusy>, kExitRival},
          {Throw<std::runtime_error>, kExitFailure},
          {[]() -> int { throw std::system_error(std::make_error_code(std::errc::io_error)); },
           kExitFailure}};
}

TEST(ExitCodeTest, AStartThatWouldFailAgainIsUsage) {
  for (const Case& one : Cases()) EXPECT_EQ(CodeOfStart(one.act), one.code_of_start);
}

// Whatever it is, hours may have gone by, and a service has to start it again.
TEST(ExitCodeTest, ARunThatWasServedIsNeverUsage) {
  for (const Case& one : Cases()) {
    EXPECT_EQ(CodeOfStart([&] { return CodeOfServing(one.act); }), kExitFailure);
  }
}

TEST(ExitCodeTest, WithoutAnExceptionItIsTheCallsOwn) {
  for (const int code :
       {kExitFinished + 0, kExitRival + 0, kExitNonFinite + 0, kExitSignalBase + 2}) {
    EXPECT_EQ(CodeOfStart([&] { return CodeOfServing([&] { return code; }); }), code);
  }
}

}  // namespace
}  // namespace metronome
