#include "learner/network/worker_team.h"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <thread>
#include <vector>

#include "common/process/cpu_times.h"
#include "common/process/start_threads.h"

namespace metronome::network {
namespace {

// An update is hundreds of short rounds: waking a thread that sleeps takes tens of microseconds.
constexpr std::chrono::microseconds kSpin{100};

/// Blocks until `value` is not `old`: busily at first, then asleep.
template <class T>
void AwaitChange(const std::atomic<T>& value, T old) {
  const auto deadline = std::chrono::steady_clock::now() + kSpin;
  do {
    for (int i = 0; i < 64; ++i) {
      if (value.load(std::memory_order_acquire) != old) return;
#if defined(__x86_64__)
      __builtin_ia32_pause();
#endif
    }
  } while (std::chrono::steady_clock::now() < deadline);
  value.wait(old, std::memory_order_acquire);
}

}  // namespace

struct WorkerTeam::Impl {
  // A thread's part of a round's tasks: it starts there, so that round by round it finds in its
  // cache what it left there. Then it helps the others.
  struct alignas(64) Share {
    std::atomic<std::size_t> next{0};
    std::size_t end = 0;
  };

  explicit Impl(int threads)
      : shares(static_cast<std::size_t>(threads)),
        workers(process::StartThreads(
            static_cast<std::size_t>(threads - 1), [this](std::size_t i) { Work(i + 1); },
            [this] { Dismiss(); }, "runtime.learner_threads")) {}

  void Dismiss() {
    stopping = true;
    NextRound();
  }

  void Work(std::size_t thread) {
    for (std::uint32_t seen = 0;; ++seen) {
      AwaitChange(round, seen);
      if (stopping) return;
      const process::CpuTimer timer(process::CpuUse::kUpdate);
      Drain(thread);
      if (--working == 0) working.notify_one();
    }
  }

  void Drain(std::size_t thread) {
    for (std::size_t i = 0; i < shares.size(); ++i) {
      Share& share = shares[(thread + i) % shares.size()];
      for (std::size_t t = share.next++; t < share.end; t = share.next++) (*task)(t);
    }
  }

  void StartRound() {
    for (std::size_t i = 0; i < shares.size(); ++i) {
      shares[i].next = i * count / shares.size();
      shares[i].end = (i + 1) * count / shares.size();
    }
    working = static_cast<int>(workers.size());
    NextRound();
  }

  void NextRound() {
    ++round;
    round.notify_all();
  }

  void AwaitWorkers() {
    for (int left = working; left > 0; left = working) AwaitChange(working, left);
  }

  // Written by the caller before a round, read by workers in it.
  const std::function<void(std::size_t)>* task = nullptr;
  std::size_t count = 0;
  bool stopping = false;
  std::vector<Share> shares;            // [threads]
  std::atomic<std::uint32_t> round{0};  // begun so far
  std::atomic<int> working{0};          // workers that have not ended this round
  std::vector<std::thread> workers;     // last: they use the others
};

WorkerTeam::WorkerTeam(int threads) {
  if (threads < 1) throw std::invalid_argument("a worker team needs at least one thread");
  impl_ = std::make_unique<Impl>(threads);
}

WorkerTeam::~WorkerTeam() {
  impl_->Dismiss();
  for (std::thread& worker : impl_->workers) worker.join();
}

std::size_t WorkerTeam::threads() const { return impl_->workers.size() + 1; }

void WorkerTeam::Run(std::size_t count, const std::function<void(std::size_t)>& task) {
  impl_->task = &task;
  impl_->count = count;
  impl_->StartRound();
  impl_->Drain(0);
  impl_->AwaitWorkers();
}

}  // namespace metronome::network
