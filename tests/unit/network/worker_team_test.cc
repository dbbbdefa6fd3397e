#include "learner/network/worker_team.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

namespace metronome::network {
namespace {

class WorkerTeamTest : public ::testing::TestWithParam<int> {};

TEST_P(WorkerTeamTest, EveryTaskOfEveryRoundRunsExactlyOnceBeforeRunReturns) {
  WorkerTeam team(GetParam());
  for (std::size_t round = 0; round < 2000; ++round) {
    std::vector<int> runs(round % 23, 0);  // from none to more than threads; no two share a task
    team.Run(runs.size(), [&](std::size_t task) { ++runs[task]; });
    ASSERT_TRUE(std::all_of(runs.begin(), runs.end(), [](int count) { return count == 1; }))
        << "round " << round;
  }
}

TEST_P(WorkerTeamTest, ThreadsThatFellAsleepBetweenRoundsWakeForTheNext) {
  WorkerTeam team(GetParam());
  for (int round = 0; round < 20; ++round) {
    std::vector<int> runs(64, 0);
    team.Run(runs.size(), [&](std::size_t task) { ++runs[task]; });
    EXPECT_EQ(std::count(runs.begin(), runs.end(), 1), 64);
    // Longer than threads wait busily. It is not waited for anything: the pause is what is tested.
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

TEST_P(WorkerTeamTest, ATeamThatNeverWorkedEnds) { const WorkerTeam team(GetParam()); }

INSTANTIATE_TEST_SUITE_P(Threads, WorkerTeamTest, ::testing::Values(1, 2, 5));

TEST(WorkerTeamSizeTest, NoThreadsAreRefused) {
  EXPECT_THROW(WorkerTeam(0), std::invalid_argument);
}

}  // namespace
}  // namespace metronome::network
