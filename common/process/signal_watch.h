#pragma once

#include <functional>
#include <thread>

namespace metronome::process {

/// Turns SIGINT, SIGTERM and SIGHUP into calls on an ordinary thread, where anything may be done. A
/// signal that is ignored when this is made stays ignored (nohup, a shell's background jobs).
/// Make it before any thread that takes signals: threads inherit the blocked ones. One per process.
class SignalWatch {
 public:
  /// @param on_signal  gets the signal's number, once per signal; must not throw.
  /// @throws std::system_error if the kernel has no descriptors left.
  explicit SignalWatch(std::function<void(int signal)> on_signal);
  /// Joins the thread; blocks while on_signal runs. The signals stay blocked.
  ~SignalWatch();
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;

 private:
  void Watch();

  const std::function<void(int)> on_signal_;
  int signals_ = -1;  // signalfd
  int stop_ = -1;     // eventfd
  std::thread thread_;
};

}  // namespace metronome::process
