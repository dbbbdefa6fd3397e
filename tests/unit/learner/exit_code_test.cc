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

namespace metronome::learner {
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
  return {{Throw<std::invalid_argument>, process::kExitUsage},
          {Throw<config::ConfigError>, process::kExitUsage},
          {Throw<run::CannotStart>, process::kExitUsage},
          {Throw<checkpoint::CheckpointError>, process::kExitUsage},
          {Throw<checkpoint::CheckpointUnreadable>, process::kExitFailure},
          {Throw<record::RunFolderBusy>, process::kExitRival},
          {Throw<std::runtime_error>, process::kExitFailure},
          {[]() -> int { throw std::system_error(std::make_error_code(std::errc::io_error)); },
           process::kExitFailure}};
}

TEST(ExitCodeTest, AStartThatWouldFailAgainIsUsage) {
  for (const Case& one : Cases()) EXPECT_EQ(CodeOfStart(one.act), one.code_of_start);
}

// Whatever it is, hours may have gone by, and a service has to start it again.
TEST(ExitCodeTest, ARunThatWasServedIsNeverUsage) {
  for (const Case& one : Cases()) {
    EXPECT_EQ(CodeOfStart([&] { return CodeOfServing(one.act); }), process::kExitFailure);
  }
}

TEST(ExitCodeTest, WithoutAnExceptionItIsTheCallsOwn) {
  for (const int code : {process::kExitFinished + 0, process::kExitRival + 0,
                         process::kExitNonFinite + 0, process::kExitSignalBase + 2}) {
    EXPECT_EQ(CodeOfStart([&] { return CodeOfServing([&] { return code; }); }), code);
  }
}

}  // namespace
}  // namespace metronome::learner
