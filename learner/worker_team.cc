#include "learner/worker_team.h"

#include <atomic>
#include <barrier>
#include <stdexcept>
#include <thread>
#include <vector>

#include "common/cpu_times.h"

namespace metronome {

struct WorkerTeam::Impl {
  explicit Impl(int threads) : start(threads), done(threads) {
    for (int i = 1; i < threads; ++i) {
      workers.emplace_back([this] {
        for (;;) {
          start.arrive_and_wait();
          if (stopping) return;
          {
            const CpuTimer timer(CpuUse::kUpdate);
            Drain();
          }
          done.arrive_and_wait();
        }
      });
    }
  }

  void Drain() {
    for (std::size_t i = next++; i < count; i = next++) (*task)(i);
  }

  // Everything below is written by the caller before `start` and read by workers after it.
  const std::function<void(std::size_t)>* task = nullptr;
  std::size_t count = 0;
  std::atomic<std::size_t> next{0};
  bool stopping = false;
  std::barrier<> start;
  std::barrier<> done;
  std::vector<std::thread> workers;
};

WorkerTeam::WorkerTeam(int threads) {
  if (threads < 1) throw std::invalid_argument("a worker team needs at least one thread");
  impl_ = std::make_unique<Impl>(threads);
}

WorkerTeam::~WorkerTeam() {
  impl_->stopping = true;
  impl_->start.arrive_and_wait();
  for (std::thread& worker : impl_->workers) worker.join();
}

void WorkerTeam::Run(std::size_t count, const std::function<void(std::size_t)>& task) {
  impl_->task = &task;
  impl_->count = count;
  impl_->next = 0;
  impl_->start.arrive_and_wait();
  impl_->Drain();
  impl_->done.arrive_and_wait();
}

}  // namespace metronome
