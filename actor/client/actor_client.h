#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "actor/client/assignment_book.h"
#include "actor/client/episode_player.h"
#include "actor/client/worker_pool.h"
#include "common/messages/bus.h"

namespace metronome::client {

struct ActorClientOptions {
  std::string run_name;
  std::string why_no_learner;  // what to look at then, for people
  int envs = 1;                // episodes at once, at least 1
  bool stay = false;           // serve the next run of this name too
  /// How long without a learner, at the start or later; std::nullopt: for ever.
  std::optional<std::chrono::milliseconds> patience = std::chrono::seconds(60);
  std::chrono::milliseconds notice_every = std::chrono::seconds(3);  // while there is no learner
  std::chrono::milliseconds idle_notice_every = std::chrono::seconds(10);  // without an assignment
  std::chrono::milliseconds status_every = std::chrono::seconds(1);
  // This actor's identity, for the learner.
  std::uint64_t actor_id = 0;
  std::string host;
  std::uint32_t pid = 0;
  std::string engine;
  std::string build;
};

/// The run's task could not be set up here (scene files are missing, say).
class SetUpFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

enum class ActorEnd {
  kFinished,   // the run is over
  kStopped,    // Stop was called
  kRefused,    // by the learner or by this actor; the reason is logged
  kNoLearner,  // patience is over
};

/// An actor's life: finds the run's learner, plays what it assigns, publishes the episodes.
///
/// Of the learners that are alive and serving it obeys the one of the newest incarnation (ties: the
/// lower id). A change of learner drops the queue and cancels running episodes. An assignment waits
/// until its snapshot is there. What makes no sense is logged and dropped.
class ActorClient {
 public:
  /// @param bus  must outlive the client; closed when Run returns or throws.
  ActorClient(ActorBus* bus, SetUpRun set_up_run, ActorClientOptions options);

  /// Blocks until the actor's life is over. Call once.
  /// @throws SetUpFailed, and what playing an episode or publishing it threw.
  ActorEnd Run();

  /// Makes Run return soon. From any thread, not from a signal handler.
  void Stop();

 private:
  struct EndOfRun;  // closes the bus and cancels the workers, whichever way Run ends

  std::optional<ActorEnd> Handle(ActorEvent event);
  std::optional<ActorEnd> HandleDescription(RunDescription description);
  std::optional<ActorEnd> HandleAssignment(const EpisodeAssignment& assignment);
  std::optional<ActorEnd> HandleLost(std::uint64_t learner_id);
  std::optional<ActorEnd> Reconsider();
  std::optional<ActorEnd> Adopt(const RunDescription& description);
  std::optional<ActorEnd> Finish();
  std::optional<ActorEnd> Tick();
  std::optional<ActorEnd> TickWithoutLearner(Clock::time_point now);
  RunSetup SetUp(const RunConfig& config) const;
  void QueueReady();
  void StartWaiting(const std::string& cause);
  void LeaveRun();
  void Deliver(std::uint64_t incarnation, Episode episode);
  void SendStatus();
  void NoticeIdleness(std::uint64_t steps, Clock::time_point now);
  [[nodiscard]] Clock::time_point NextTick() const;

  ActorBus* const bus_;
  const SetUpRun set_up_run_;
  const ActorClientOptions options_;
  std::atomic<bool> stopped_{false};
  std::atomic<std::uint64_t> episodes_done_{0};

  std::map<std::uint64_t, RunDescription> learners_;  // alive, by id
  std::optional<RunDescription> obeyed_;              // alive or not
  RunConfig config_;                                  // of obeyed_
  std::string canonical_digest_;                      // of obeyed_
  std::optional<Clock::time_point> waiting_since_;    // set while no learner is obeyed and alive
  std::string waiting_for_;                           // what the notice says of it
  std::string hint_;  // for the first notice; empty once it is said or a learner is heard
  Clock::time_point next_notice_;
  Clock::time_point next_status_;
  Clock::time_point last_status_;
  std::uint64_t steps_at_last_status_ = 0;
  Clock::time_point idle_since_;  // nothing was played or assigned since
  Clock::time_point next_idle_notice_;
  AssignmentBook book_;
  std::unique_ptr<WorkerPool> workers_;  // of obeyed_
};

}  // namespace metronome::client
