#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "actor/client/assignment_book.h"
#include "actor/client/episode_player.h"
#include "common/process/mutex.h"

namespace metronome::client {

/// One thread a player, and the queue of episodes that they share. Thread-safe.
class WorkerPool {
 public:
  /// Gets each finished episode, on a worker's thread, many at once. May block: that worker waits.
  using Deliver = std::function<void(Episode episode)>;

  /// @param on_failure  called once, on a worker's thread, when playing or delivering threw; see
  ///                    failure().
  /// @throws std::runtime_error if a thread cannot be started.
  WorkerPool(std::vector<std::unique_ptr<EpisodePlayer>> players, Deliver deliver,
             std::function<void()> on_failure);
  /// Cancels and joins; blocks as long as the slowest step or `deliver` does.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Queues episodes behind those queued already. Never blocks.
  void Add(std::vector<EpisodeTask> tasks);
  /// Empties the queue and ends running episodes at their next step. Final. Never blocks.
  void Cancel();

  [[nodiscard]] std::uint64_t steps() const { return steps_; }  // of episodes played to the end
  [[nodiscard]] std::exception_ptr failure() const;             // the first one, or null

 private:
  void Work(EpisodePlayer& player);
  bool PlayNext(EpisodePlayer& player);

  const Deliver deliver_;
  const std::function<void()> on_failure_;
  std::atomic<bool> cancelled_{false};
  std::atomic<std::uint64_t> steps_{0};
  mutable process::Mutex mutex_;
  std::condition_variable changed_;
  std::deque<EpisodeTask> queue_ METRONOME_GUARDED_BY(mutex_);
  std::exception_ptr failure_ METRONOME_GUARDED_BY(mutex_);
  const std::vector<std::unique_ptr<EpisodePlayer>> players_;
  std::vector<std::thread> threads_;
};

}  // namespace metronome::client
