#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>

#include "common/messages/bus.h"
#include "learner/algorithm/algorithm.h"
#include "learner/collect/collector.h"
#include "learner/record/run_record.h"
#include "learner/run/background.h"
#include "learner/run/background_update.h"
#include "learner/run/rival_watch.h"
#include "learner/run/status_report.h"

namespace metronome::run {

/// The facts and rules of a run, told to the coordinator once.
struct CoordinatorSetup {
  RunDescription description;  // serving and finished are the coordinator's to set
  collect::assignments::AssignmentRules
      rules;  // updates_total: where episodes end early, more than there ever will be
  /// Of the environment: the run ends with the update that reaches them, or with the last one.
  std::uint64_t total_steps = std::numeric_limits<std::uint64_t>::max();
  collect::trust::TrustRules trust;
  collect::trust::AuditRules audit;
  collect::trust::ExcludedHosts excluded;  // by earlier starts
  std::string canonical_digest;            // the checkpoint's; empty at first
  StatusFacts status;
  std::function<void(const LearnerStatus&)> on_status;  // called with each that is published
  double seconds_before = 0;           // wall-clock: that the run took before this incarnation
  std::uint64_t checkpoint_every = 1;  // updates
  std::uint64_t milestone_every = 0;   // updates; 0: none
  bool resumed = false;                // the state is that of an existing checkpoint
  std::string how_to_join;             // command that starts an actor, for people
  RivalTimes rivals;
  std::chrono::milliseconds first_call_for_actors{3000};
  std::chrono::milliseconds call_for_actors_every{5000};
  std::chrono::milliseconds farewell{5000};  // actors have this long to leave a finished run
};

/// The learner's main loop: looks for rivals, assigns and gathers episodes, has them learnt from,
/// publishes weights, keeps checkpoints, ends the run. One thread, which only ever waits in
/// LearnerBus::Wait; updates run beside it in `background`.
class Coordinator {
 public:
  using TimePoint = Clock::time_point;

  /// The arguments must outlive the coordinator.
  /// @param now  the clock that bus.Wait's deadlines refer to.
  Coordinator(CoordinatorSetup setup, LearnerBus& bus, algorithm::Algorithm& algorithm,
              record::RunRecord& record, Background& background,
              std::function<TimePoint()> now = Clock::now);
  Coordinator(const Coordinator&) = delete;
  Coordinator& operator=(const Coordinator&) = delete;

  /// Serves the run to its end, a stop, or an error; call once. @return an ExitCode
  /// (common/process/exit_codes.h). @throws std::runtime_error if the bus fails
  /// or the run's files cannot be opened at the start.
  int Run();

  /// Ends Run with a checkpoint and 128 + signal; if none can be written, with
  /// process::kExitFailure. Any thread; not from a signal handler.
  void RequestStop(int signal);

 private:
  std::optional<int> AwaitRivals();
  bool Begin();
  void PublishState(bool previous_too);
  void Serve();
  void ServeOnce();
  void Handle(LearnerEvent event, TimePoint now);
  void KeepExclusions(TimePoint now);
  void OnRival(const RivalSeen& rival, TimePoint now);
  void CallForActors(TimePoint now);
  void PublishStatus(LearnerStatus::State state);
  [[nodiscard]] LearnerStatus::State StateNow() const;
  [[nodiscard]] bool IsFinished() const;  // with learning; what is left is to say so

  void StartUpdateIfReady();
  void FinishUpdateIfDone();
  void OnUpdateFailed(const std::exception_ptr& error);
  void WaitForUpdate();
  void TellLearnt(const BackgroundUpdate::Outcome& outcome);
  void TellProgress(const BackgroundUpdate::Outcome& outcome);
  [[nodiscard]] record::WallReport WallReportOf(const BackgroundUpdate::Outcome& outcome);

  [[nodiscard]] checkpoint::TrainState CopyState() const;
  bool Save(const checkpoint::TrainState& state);
  int End();
  int EndFinished(const checkpoint::TrainState& state);
  void Farewell();
  [[nodiscard]] std::string AccountingText() const;

  CoordinatorSetup setup_;
  LearnerBus& bus_;
  algorithm::Algorithm& algorithm_;
  record::RunRecord& record_;
  std::function<TimePoint()> now_;

  RivalWatch rivals_;
  collect::Collector collector_;
  StatusReport status_;
  std::size_t exclusions_kept_;
  TimePoint keep_exclusions_from_;  // after one that could not be written
  std::uint64_t version_;           // updates made and published
  std::uint64_t steps_;             // of the environment, in these updates
  std::optional<std::uint64_t> saved_version_;
  TimePoint serving_since_;
  std::map<std::uint64_t, TimePoint> published_;  // when each of the last versions went out
  std::optional<TimePoint> next_call_;

  std::atomic<int> stop_signal_{0};
  std::optional<int> ending_;  // exit code; the loop ends when it is set
  BackgroundUpdate update_;    // last: what runs there refers to the rest
};

}  // namespace metronome::run
