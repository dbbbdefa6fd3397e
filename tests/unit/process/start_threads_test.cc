#include "common/process/start_threads.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <stdexcept>
#include <string>

#include "actor/client/worker_pool.h"

namespace metronome::process {
namespace {

constexpr std::size_t kTooMany = 64;  // of threads, for the room that is left

/// Leaves room for the stacks of some threads, not of kTooMany (2 MB at least each).
void LimitAddressSpace() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlim_t room = pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + (rlim_t{100} << 20);
  const rlimit limit{room, room};
  if (setrlimit(RLIMIT_AS, &limit) != 0) _exit(2);
}

/// Whether `start` throws an error that names `option`, in a process with little address space.
template <class Start>
void ExpectNamedError(const Start& start, const std::string& option) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    LimitAddressSpace();
    try {
      start();
    } catch (const std::runtime_error& error) {
      _exit(std::string(error.what()).find(option) == std::string::npos ? 3 : 0);
    }
    _exit(4);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(StartThreadsTest, EachRunsItsOwnNumber) {
  std::atomic<std::size_t> sum{0};
  auto threads = StartThreads(
      5, [&](std::size_t i) { sum += i; }, [] {}, "--threads");
  EXPECT_EQ(threads.size(), 5U);
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(sum, 0U + 1 + 2 + 3 + 4);
}

TEST(StartThreadsTest, IfOneCannotBeStartedThoseThatRunAreStoppedAndItIsAnError) {
  ExpectNamedError(
      [] {
        std::atomic<bool> stopped{false};
        const auto wait = [&stopped](std::size_t) { stopped.wait(false); };
        const auto stop = [&stopped] {
          stopped = true;
          stopped.notify_all();
        };
        static_cast<void>(StartThreads(kTooMany, wait, stop, "--threads"));
      },
      "choose fewer by --threads");
}

TEST(ShareOutTest, EachIndexIsGivenOnceWhateverTheThreads) {
  for (const std::size_t threads : {1U, 3U, 8U}) {
    std::vector<std::atomic<int>> times(5);
    std::atomic<std::size_t> workers{0};
    const auto make_worker = [&]() -> Worker {
      ++workers;
      return [&](std::size_t i) { ++times.at(i); };
    };
    ShareOut(times.size(), threads, make_worker, "--threads");
    EXPECT_EQ(workers, threads);
    for (const auto& one : times) EXPECT_EQ(one, 1);
  }
}

TEST(ShareOutTest, AFailureStopsTheOthersAndIsTold) {
  constexpr std::size_t kMany = 100'000'000;
  std::atomic<bool> failed{false};
  std::atomic<std::size_t> done{0};
  const auto worker = [&](std::size_t i) {
    if (i == 0) {
      failed = true;
      failed.notify_all();
      throw std::runtime_error("the first index");
    }
    failed.wait(false);
    std::this_thread::yield();  // the failure has its turn
    ++done;
  };
  ExpectNamedError(
      [&] {
        ShareOut(
            kMany, 2, [&] { return Worker(worker); }, "--threads");
      },
      "the first index");
  EXPECT_LT(done, kMany - 1);
}

class IdlePlayer final : public client::EpisodePlayer {
 public:
  std::optional<Episode> Play(const PolicySnapshot&, std::uint64_t,
                              const std::atomic<bool>&) override {
    return std::nullopt;
  }
};

TEST(StartThreadsTest, AWorkerPoolOfTooManyIsAnError) {
  ExpectNamedError(
      [] {
        std::vector<std::unique_ptr<client::EpisodePlayer>> players(kTooMany);
        for (auto& player : players) player = std::make_unique<IdlePlayer>();
        const client::WorkerPool pool(
            std::move(players), [](const Episode&) {}, [] {});
      },
      "choose fewer by --envs");
}

}  // namespace
}  // namespace metronome::process
