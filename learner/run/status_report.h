#pragma once

#include <cstdint>
#include <string>

#include "common/messages/bus.h"
#include "learner/algorithm/update_report.h"
#include "learner/collect/collector.h"
#include "learner/record/metrics.h"
#include "learner/record/run_length.h"

namespace metronome::run {

/// The part of a learner's status that never changes.
struct StatusFacts {
  std::string task;
  std::string host;
  std::uint32_t pid = 0;
  record::RunLength length;
};

/// Makes the status that people watch, and knows when the next one is due. Not thread-safe.
class StatusReport {
 public:
  using TimePoint = Clock::time_point;
  static constexpr std::chrono::seconds kPeriod{1};

  /// @param description  of the learner. @param rules  of the run.
  StatusReport(StatusFacts facts, const RunDescription& description,
               const collect::assignments::AssignmentRules& rules);

  /// The run is served from here on. @param seconds_before  that it took before this incarnation.
  void Begin(std::uint64_t version, std::uint64_t steps, double seconds_before, TimePoint now);
  void Updated(const algorithm::UpdateReport& report, const record::WallReport& wall);
  void Saved(std::uint64_t version) { status_.checkpoint_version = version; }

  [[nodiscard]] TimePoint due() const { return due_; }
  /// The next one is due a period later.
  LearnerStatus Make(LearnerStatus::State state, const collect::Collector& collector,
                     const LearnerBus& bus, TimePoint now);

 private:
  void SetRates(TimePoint now);

  const record::RunLength length_;
  LearnerStatus status_;  // its last values; Make fills in the rest
  double seconds_before_ = 0;
  TimePoint begun_;
  TimePoint due_;
};

}  // namespace metronome::run
