#pragma once

#include <cstdint>
#include <string>
#include <vector>

/// The status of a learner and its actors, for whoever watches. The lists below are its one
/// description: the structs, the conversion to the wire (common/dds/convert.cc), the JSON of
/// `status` and the metrics of Prometheus (learner/watch/) follow from them.
namespace metronome {

/// The stages of a learner's life.
enum class LearnerState : std::uint8_t {
  kWaitingForActors = 0,
  kCollecting = 1,
  kUpdating = 2,
  kFinished = 3,
  kStopped = 4,  // before its end
};

/// "collecting" and the like, for people.
std::string StateText(LearnerState state);

/// FIELD(type, name, metric, help) for each number of a run. `name` is that of the IDL and of JSON;
/// `metric` that of Prometheus, behind "metronome_": a counter if it ends with "_total". Episodes
/// from accepted to stale and bytes are counted in this incarnation of the learner; what is of the
/// last update is 0 before the first one since then.
#define METRONOME_RUN_NUMBERS(FIELD)                                                               \
  FIELD(std::uint64_t, version, "updates_total", "Updates made since the run began.")              \
  FIELD(std::uint64_t, updates_total, "updates_planned",                                           \
        "Updates that the whole run will have made.")                                              \
  FIELD(std::uint64_t, steps, "steps_total", "Environment steps learnt from since the run began.") \
  FIELD(std::uint64_t, total_steps, "steps_planned",                                               \
        "Environment steps that the whole run will have made.")                                    \
  FIELD(double, mean_return, "return", "Mean undiscounted return of the last update's episodes.")  \
  FIELD(double, success, "success_ratio",                                                          \
        "Share, 0 to 1, of the last update's episodes that succeeded at any step.")                \
  FIELD(double, success_end, "success_at_end_ratio",                                               \
        "Share, 0 to 1, of the last update's episodes that succeeded at their last step.")         \
  FIELD(double, fps, "steps_per_second", "Mean environment steps per second since the run began.") \
  FIELD(double, seconds, "run_duration_seconds",                                                   \
        "Seconds that the run has taken, all starts of the learner together.")                     \
  FIELD(double, eta_seconds, "run_remaining_seconds",                                              \
        "Estimated seconds until the run ends; 0 while unknown.")                                  \
  FIELD(double, collect_seconds, "collect_duration_seconds",                                       \
        "Seconds that collecting the last update's episodes took.")                                \
  FIELD(double, update_seconds, "update_duration_seconds",                                         \
        "Seconds that learning from the last update's episodes took.")                             \
  FIELD(double, idle_share, "envs_idle_ratio",                                                     \
        "Share, 0 to 1, of the actors' time that was idle during the last update.")                \
  FIELD(std::uint64_t, batch_episodes, "batch_episodes",                                           \
        "Episodes of the current batch that have arrived.")                                        \
  FIELD(std::uint64_t, episodes_per_update, "batch_episodes_wanted",                               \
        "Episodes that an update needs.")                                                          \
  FIELD(std::uint64_t, accepted, "episodes_accepted_total", "Episodes that passed the check.")     \
  FIELD(std::uint64_t, reassigned, "episodes_reassigned_total",                                    \
        "Episodes assigned again: lost, late or doubtful.")                                        \
  FIELD(std::uint64_t, duplicates, "episodes_duplicate_total", "Episodes that came again.")        \
  FIELD(std::uint64_t, rejected, "episodes_rejected_total", "Episodes that failed the check.")     \
  FIELD(std::uint64_t, stale, "episodes_stale_total",                                              \
        "Episodes that arrived for an earlier incarnation.")                                       \
  FIELD(std::uint64_t, bytes_sent, "sent_bytes_total", "Payload bytes sent over DDS.")             \
  FIELD(std::uint64_t, bytes_received, "received_bytes_total", "Payload bytes received over DDS.") \
  FIELD(std::uint64_t, checkpoint_version, "checkpoint_version",                                   \
        "Number of the update that the newest checkpoint on disk was written after.")              \
  FIELD(std::uint64_t, actors_total, "actors", "Actors connected.")                                \
  FIELD(std::uint64_t, envs_total, "envs", "Episodes that all connected actors play at once.")

/// The same for each number of one actor.
#define METRONOME_ACTOR_NUMBERS(FIELD)                                                         \
  FIELD(std::uint32_t, envs, "actor_envs", "Episodes that the actor plays at once.")           \
  FIELD(std::uint64_t, episodes_done, "actor_episodes_played_total",                           \
        "Episodes that the actor has played, for all learners that it served.")                \
  FIELD(double, steps_per_second, "actor_steps_per_second",                                    \
        "Environment steps per second, as the actor reports them.")                            \
  FIELD(std::uint64_t, accepted, "actor_episodes_accepted_total",                              \
        "Episodes of the actor that passed the check.")                                        \
  FIELD(std::uint64_t, rejected, "actor_episodes_rejected_total",                              \
        "Episodes of the actor that failed the check.")                                        \
  FIELD(std::uint64_t, assignments, "actor_assignments",                                       \
        "Assignments that the actor has not answered.")                                        \
  FIELD(double, oldest_assignment_seconds, "actor_oldest_assignment_age_seconds",              \
        "Seconds since the oldest assignment that the actor has not answered; 0 without one.") \
  FIELD(double, silent_seconds, "actor_status_age_seconds",                                    \
        "Seconds since the actor's last message.")                                             \
  FIELD(bool, on_probation, "actor_on_probation",                                              \
        "1 if actors of this host come and go, and others are preferred; else 0.")             \
  FIELD(bool, unanswering, "actor_unanswering",                                                \
        "1 if the actor gave up an assignment and has brought nothing since; else 0.")

/// The same for each number of one of several tasks.
#define METRONOME_TASK_NUMBERS(FIELD)                                                            \
  FIELD(double, mean_return, "task_return",                                                      \
        "Mean undiscounted return of the task's episodes in the last update.")                   \
  FIELD(double, success, "task_success_ratio",                                                   \
        "Share, 0 to 1, of the task's episodes in the last update that succeeded at any step.")  \
  FIELD(double, success_end, "task_success_at_end_ratio",                                        \
        "Share, 0 to 1, of the task's episodes in the last update that succeeded at their last " \
        "step.")

/// FIELD(type, name) for each field that says which learner this is, and its state.
#define METRONOME_LEARNER_IDENTITY(FIELD) \
  FIELD(std::string, run_name)            \
  FIELD(std::uint64_t, incarnation)       \
  FIELD(std::uint64_t, learner_id)        \
  FIELD(std::string, task)                \
  FIELD(std::string, engine)              \
  FIELD(std::string, host)                \
  FIELD(std::uint32_t, pid)               \
  FIELD(LearnerState, state)

#define METRONOME_MEMBER(type, name, ...) type name{};

/// One actor as the learner sees it.
struct ActorReport {
  std::string name;  // host:pid
  METRONOME_ACTOR_NUMBERS(METRONOME_MEMBER)
  bool operator==(const ActorReport&) const = default;
};

/// One of several tasks that are learnt together.
struct TaskStatus {
  std::string name;
  METRONOME_TASK_NUMBERS(METRONOME_MEMBER)
  bool operator==(const TaskStatus&) const = default;
};

/// Learner to whoever watches, about once a second and at the end. Wall-clock: shown, never used.
struct LearnerStatus {
  using State = LearnerState;
  METRONOME_LEARNER_IDENTITY(METRONOME_MEMBER)
  METRONOME_RUN_NUMBERS(METRONOME_MEMBER)
  std::vector<TaskStatus> tasks;    // of several, each
  std::vector<ActorReport> actors;  // all of them, or as many as the wire carries
  double age_seconds = 0;           // not sent: since it was written, as whoever watches reckons
  bool operator==(const LearnerStatus&) const = default;
};

#undef METRONOME_MEMBER

/// How a number is named and explained; see METRONOME_RUN_NUMBERS.
struct StatusNumber {
  const char* name;
  const char* metric;
  const char* help;
};

/// The four below call `visit` for each field of a list, in its order.
/// @param visit  takes the name and a pointer to the member.
template <class Visit>
void VisitLearnerIdentity(Visit visit) {
#define METRONOME_VISIT(type, name) visit(#name, &LearnerStatus::name);
  METRONOME_LEARNER_IDENTITY(METRONOME_VISIT)
#undef METRONOME_VISIT
}

/// @param visit  takes a StatusNumber and a pointer to the member.
template <class Visit>
void VisitRunNumbers(Visit visit) {
#define METRONOME_VISIT(type, name, metric, help) \
  visit(StatusNumber{#name, "metronome_" metric, help}, &LearnerStatus::name);
  METRONOME_RUN_NUMBERS(METRONOME_VISIT)
#undef METRONOME_VISIT
}

/// @param visit  takes a StatusNumber and a pointer to the member.
template <class Visit>
void VisitActorNumbers(Visit visit) {
#define METRONOME_VISIT(type, name, metric, help) \
  visit(StatusNumber{#name, "metronome_" metric, help}, &ActorReport::name);
  METRONOME_ACTOR_NUMBERS(METRONOME_VISIT)
#undef METRONOME_VISIT
}

/// @param visit  takes a StatusNumber and a pointer to the member.
template <class Visit>
void VisitTaskNumbers(Visit visit) {
#define METRONOME_VISIT(type, name, metric, help) \
  visit(StatusNumber{#name, "metronome_" metric, help}, &TaskStatus::name);
  METRONOME_TASK_NUMBERS(METRONOME_VISIT)
#undef METRONOME_VISIT
}

}  // namespace metronome
