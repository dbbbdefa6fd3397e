#include "common/process/start_threads.h"

#include <stdexcept>
#include <system_error>

namespace metronome {

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

}  // namespace metronome
