#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace metronome::process {

/// Starts `count` threads; thread i runs work(i), which must not throw. They are the caller's to
/// join.
/// @param stop    makes the threads that run already end; called once, if one cannot be started.
/// @param option  what sets the count, for the message.
/// @throws std::runtime_error if one cannot be started; then none runs any more.
std::vector<std::thread> StartThreads(std::size_t count,
                                      const std::function<void(std::size_t)>& work,
                                      const std::function<void()>& stop, const std::string& option);

/// The work of one thread on the index that it is given.
using Worker = std::function<void(std::size_t)>;

/// Shares the indices 0 to count - 1 out over `threads` threads, each of which makes a worker of
/// its own; which thread gets which index is open. Where one fails the others take no further
/// index. @return when all are done. @throws what the first failure threw, and as StartThreads.
void ShareOut(std::size_t count, std::size_t threads, const std::function<Worker()>& make_worker,
              const std::string& option);

}  // namespace metronome::process
