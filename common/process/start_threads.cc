#include "common/process/start_threads.h"

#include <atomic>
#include <exception>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "common/process/mutex.h"

namespace metronome::process {
namespace {

/// The first of what threads throw.
class FirstFailure {
 public:
  void Keep(std::exception_ptr failure) {
    const MutexLock lock(mutex_);
    if (!failure_) failure_ = std::move(failure);
  }
  void Rethrow() {
    const MutexLock lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  Mutex mutex_;
  std::exception_ptr failure_ METRONOME_GUARDED_BY(mutex_);
};

}  // namespace

std::vector<std::thread> StartThreads(std::size_t count,
                                      const std::function<void(std::size_t)>& work,
                                      const std::function<void()>& stop,
                                      const std::string& option) {
  std::vector<std::thread> threads;
  threads.reserve(count);
  try {
    while (threads.size() < count) threads.emplace_back(work, threads.size());
  } catch (const std::system_error& error) {
    // A thread that is destroyed before it is joined ends the process.
    stop();
    for (std::thread& thread : threads) thread.join();
    throw std::runtime_error("only " + std::to_string(threads.size()) + " of " +
                             std::to_string(count) + " threads could be started (" +
                             error.code().message() + "): choose fewer by " + option);
  }
  return threads;
}

void ShareOut(std::size_t count, std::size_t threads, const std::function<Worker()>& make_worker,
              const std::string& option) {
  std::atomic<std::size_t> next{0};
  FirstFailure failure;
  const auto work = [&](std::size_t /*thread*/) {
    try {
      const Worker worker = make_worker();
      for (std::size_t i = next++; i < count; i = next++) worker(i);
    } catch (...) {
      next = count;
      failure.Keep(std::current_exception());
    }
  };
  for (std::thread& thread : StartThreads(
           threads, work, [&] { next = count; }, option)) {
    thread.join();
  }
  failure.Rethrow();
}

}  // namespace metronome::process
