#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace metronome::network {

/// A fixed team of threads that shares out independent tasks. Which thread runs a task is left to
/// chance; results must go to places that the task's index names.
class WorkerTeam {
 public:
  /// @param threads  in all, the caller included; at least 1. @throws std::runtime_error if they
  ///                 cannot all be started.
  explicit WorkerTeam(int threads);
  ~WorkerTeam();
  WorkerTeam(const WorkerTeam&) = delete;
  WorkerTeam& operator=(const WorkerTeam&) = delete;

  [[nodiscard]] std::size_t threads() const;

  /// Runs task(0) .. task(count - 1) and returns when all are done. One call at a time. Tasks must
  /// not throw.
  void Run(std::size_t count, const std::function<void(std::size_t)>& task);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace metronome::network
