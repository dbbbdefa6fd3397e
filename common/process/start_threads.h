#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace metronome {

/// Starts `count` threads; thread i runs work(i), which must not throw. They are the caller's to
/// join.
/// @param stop    makes the threads that run already end; called once, if one cannot be started.
/// @param option  what sets the count, for the message.
/// @throws std::runtime_error if one cannot be started; then none runs any more.
std::vector<std::thread> StartThreads(std::size_t count,
                                      const std::function<void(std::size_t)>& work,
                                      const std::function<void()>& stop, const std::string& option);

}  // namespace metronome
