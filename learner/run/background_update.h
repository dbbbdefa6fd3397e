#pragma once

#include <exception>
#include <functional>
#include <optional>

#include "common/messages/bus.h"
#include "common/process/mutex.h"
#include "learner/algorithm/algorithm.h"
#include "learner/collect/collector.h"
#include "learner/run/background.h"

namespace metronome::run {

/// The hand-over of a batch to the thread that learns from it, and of what came of it back. For one
/// thread, the coordinator's.
class BackgroundUpdate {
 public:
  using TimePoint = Clock::time_point;

  /// The outcome of a batch.
  struct Outcome {
    collect::Collector::Collected collected;
    double collect_seconds = 0;
    algorithm::UpdateReport report;
    double seconds = 0;        // that learning took
    std::exception_ptr error;  // in place of the report
  };

  /// @param wake  called by the other thread once there is an outcome. All must outlive this.
  BackgroundUpdate(algorithm::Algorithm* algorithm, Background* background,
                   std::function<TimePoint()> now, std::function<void()> wake);
  /// Waits for the other thread.
  ~BackgroundUpdate();
  BackgroundUpdate(const BackgroundUpdate&) = delete;
  BackgroundUpdate& operator=(const BackgroundUpdate&) = delete;

  /// @throws std::logic_error while another one runs.
  void Start(collect::Collector::Collected collected, double collect_seconds);
  /// Between Start and the outcome's being taken.
  [[nodiscard]] bool runs() const { return runs_; }
  /// Never blocks for long. @return what came of it, once.
  std::optional<Outcome> Take();

 private:
  void Learn(Outcome outcome);

  algorithm::Algorithm& algorithm_;
  Background& background_;
  std::function<TimePoint()> now_;
  std::function<void()> wake_;
  bool runs_ = false;
  process::Mutex mutex_;
  std::optional<Outcome> outcome_ METRONOME_GUARDED_BY(mutex_);
};

}  // namespace metronome::run
