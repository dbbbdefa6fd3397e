#include "common/process/cpu_times.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>
#include <vector>

namespace metronome::process {
namespace {

/// Keeps the calling thread busy for so much of its own CPU time.
void Burn(double seconds) {
  const double end = ThreadCpuSeconds() + seconds;
  while (ThreadCpuSeconds() < end) {
  }
}

TEST(CpuTimesTest, ATimerCountsItsThreadsWorkAndNotTheTimeThatPasses) {
  const CpuTimes& times = CpuTimes::OfProcess();
  const double before = times.seconds(CpuUse::kCheck);
  {
    const CpuTimer timer(CpuUse::kCheck);
    Burn(0.02);
    std::thread([] { Burn(0.05); }).join();  // another thread's work, and our waiting for it
  }
  EXPECT_NEAR(times.seconds(CpuUse::kCheck) - before, 0.02, 0.01);
}

TEST(CpuTimesTest, ThreadsThatCountAtOnceLoseNothing) {
  CpuTimes times;
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&times] {
      for (int j = 0; j < 10000; ++j) times.Add(CpuUse::kPolicy, 1e-6);
    });
  }
  threads.clear();
  EXPECT_NEAR(times.seconds(CpuUse::kPolicy), 0.04, 1e-9);
}

TEST(CpuTimesTest, TheReportNamesWhatTookTimeAndTheRest) {
  CpuTimes times;
  times.Add(CpuUse::kPhysics, 10.104);
  times.Add(CpuUse::kSetUp, 0.25);
  const std::string report = times.Report();
  EXPECT_NE(report.find(" CPU seconds: set-up 0.25, physics 10.10, rest "), std::string::npos)
      << report;
}

}  // namespace
}  // namespace metronome::process
