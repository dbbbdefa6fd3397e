#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>

namespace metronome::process {

/// Writes to a file descriptor from a thread of its own, so that a reader who stands still (a
/// paused terminal, a full pipe) holds up nobody else. What cannot be written (nobody reads any
/// more, the disk is full) is dropped. Thread-safe.
class OutputThread {
 public:
  static constexpr std::size_t kMostWaiting = std::size_t{1} << 20;  // bytes
  static constexpr std::chrono::milliseconds kFarewell{2000};

  /// The thread takes no signals.
  /// @param descriptor  stays open for as long as the process writes; not closed here.
  /// @throws std::system_error if no thread can be started.
  explicit OutputThread(int descriptor);
  /// Waits at most kFarewell for what is still to be written.
  ~OutputThread();
  OutputThread(const OutputThread&) = delete;
  OutputThread& operator=(const OutputThread&) = delete;

  /// Queues `text`, whole lines. Never waits: beyond kMostWaiting bytes the oldest texts are
  /// dropped.
  void Write(std::string text);

  /// Waits until all is written, at most `timeout`; not at all while the reader is known to stand
  /// still. @return whether all is written.
  bool Flush(std::chrono::milliseconds timeout);

 private:
  struct State;
  static void Work(State& state);

  // The thread's too, which is left alone where a write never returns.
  std::shared_ptr<State> state_;
};

}  // namespace metronome::process
