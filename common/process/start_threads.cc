#include "common/process/start_threads.h"

#include <atomic>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <system_error>

namespace metronome::process {

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
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&](std::size_t /*thread*/) {
    try {
      const Worker worker = make_worker();
      for (std::size_t i = next++; i < count; i = next++) worker(i);
    } catch (...) {
      next = count;
      const std::lock_guard lock(failure_mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  for (std::thread& thread : StartThreads(
           threads, work, [&] { next = count; }, option)) {
    thread.join();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace metronome::process
