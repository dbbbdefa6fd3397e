#pragma once

#include <functional>
#include <vector>

/// Child processes and the processor time of this one. Not thread-safe.
namespace metronome::bench {

/// A child that runs `body` and ends; to be made before any thread or DDS participant.
/// @return its process id. @throws std::runtime_error.
int Fork(const std::function<void()>& body);

/// Waits for the children. @return their processor seconds, user and system, from start to end.
/// @throws std::runtime_error if one did not end well.
double WaitForAll(const std::vector<int>& children);

/// Processor seconds, user and system, of all threads of this process so far; of this thread.
double ProcessSeconds();
double ThreadSeconds();

/// A pipe of fixed-size records from children to their parent.
class Pipe {
 public:
  Pipe();  // @throws std::runtime_error
  ~Pipe();
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  /// Atomic: T is smaller than PIPE_BUF. @throws std::runtime_error.
  template <class T>
  void Write(const T& record) {
    WriteBytes(&record, sizeof record);
  }
  /// Blocks. @throws std::runtime_error.
  template <class T>
  T Read() {
    T record;
    ReadBytes(&record, sizeof record);
    return record;
  }

 private:
  void WriteBytes(const void* data, unsigned long bytes);
  void ReadBytes(void* data, unsigned long bytes);
  int ends_[2];
};

}  // namespace metronome::bench
