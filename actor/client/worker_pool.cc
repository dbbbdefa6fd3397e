#include "actor/client/worker_pool.h"

#include <utility>

#include "common/process/cpu_times.h"
#include "common/process/start_threads.h"

namespace metronome::client {

WorkerPool::WorkerPool(std::vector<std::unique_ptr<EpisodePlayer>> players, Deliver deliver,
                       std::function<void()> on_failure)
    : deliver_(std::move(deliver)),
      on_failure_(std::move(on_failure)),
      players_(std::move(players)) {
  threads_ = process::StartThreads(
      players_.size(), [this](std::size_t env) { Work(*players_[env]); }, [this] { Cancel(); },
      "--envs");
}

WorkerPool::~WorkerPool() {
  Cancel();
  for (std::thread& thread : threads_) thread.join();
}

void WorkerPool::Add(std::vector<EpisodeTask> tasks) {
  {
    const process::MutexLock lock(mutex_);
    if (cancelled_) return;
    for (EpisodeTask& task : tasks) queue_.push_back(std::move(task));
  }
  changed_.notify_all();
}

void WorkerPool::Cancel() {
  {
    const process::MutexLock lock(mutex_);
    cancelled_ = true;
    queue_.clear();
  }
  changed_.notify_all();
}

std::exception_ptr WorkerPool::failure() const {
  const process::MutexLock lock(mutex_);
  return failure_;
}

void WorkerPool::Work(EpisodePlayer& player) {
  try {
    while (PlayNext(player)) {
    }
  } catch (...) {
    {
      const process::MutexLock lock(mutex_);
      if (failure_ != nullptr) return;
      failure_ = std::current_exception();
    }
    on_failure_();
  }
}

bool WorkerPool::PlayNext(EpisodePlayer& player) {
  EpisodeTask task;
  {
    process::MutexLock lock(mutex_);
    changed_.wait(lock,
                  [this]() METRONOME_REQUIRES(mutex_) { return cancelled_ || !queue_.empty(); });
    if (cancelled_) return false;
    task = std::move(queue_.front());
    queue_.pop_front();
  }
  auto episode = player.Play(*task.snapshot, task.number, cancelled_);
  if (!episode) return false;
  steps_ += static_cast<std::uint64_t>(episode->length());
  const process::CpuTimer timer(process::CpuUse::kSend);
  deliver_(*std::move(episode));
  return true;
}

}  // namespace metronome::client
