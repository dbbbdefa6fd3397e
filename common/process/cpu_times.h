#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>

namespace metronome::process {

/// Uses of a process's CPU time. Whatever is not named - middleware threads above all - is
/// the rest.
enum class CpuUse : std::size_t {
  kSetUp,    // actor: loading scenes, the canonical episode
  kPhysics,  // actor: environment steps, reward and observation included
  kReset,    // actor
  kPolicy,   // actor: mean, noise, log-probability
  kRollout,  // actor: what else an episode takes
  kSend,     // actor: an episode to its wire form and into the writer
  kCheck,    // learner: recomputing an episode's actions and log-probabilities
  kUpdate,   // learner: all threads of an update
  kSave,     // learner: checkpoints and progress
  kCount
};

/// CPU seconds of this process by use. Thread-safe, lock-free.
class CpuTimes {
 public:
  /// The process's own.
  static CpuTimes& OfProcess();

  void Add(CpuUse use, double seconds);
  [[nodiscard]] double seconds(CpuUse use) const;

  /// One line: "12.30 CPU seconds: physics 10.10, reset 0.31, ..., rest 0.50". Uses without time
  /// are left out; the rest is what the process took beyond them.
  [[nodiscard]] std::string Report() const;

 private:
  std::array<std::atomic<std::int64_t>, static_cast<std::size_t>(CpuUse::kCount)> nanoseconds_{};
};

/// CPU seconds that the calling thread has taken.
double ThreadCpuSeconds();

/// Counts the calling thread's CPU time between its making and its end.
class CpuTimer {
 public:
  explicit CpuTimer(CpuUse use) : use_(use), begin_(ThreadCpuSeconds()) {}
  ~CpuTimer() { CpuTimes::OfProcess().Add(use_, ThreadCpuSeconds() - begin_); }
  CpuTimer(const CpuTimer&) = delete;
  CpuTimer& operator=(const CpuTimer&) = delete;

 private:
  const CpuUse use_;
  const double begin_;
};

}  // namespace metronome::process
