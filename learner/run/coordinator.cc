#include "learner/run/coordinator.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <type_traits>
#include <utility>
#include <variant>

#include "common/process/cpu_times.h"
#include "common/process/exit_codes.h"

namespace metronome::run {
namespace {

// Nothing is due before this: waiting longer would be as good.
constexpr std::chrono::seconds kLongWait{60};
constexpr std::chrono::seconds kExclusionsAgain{10};

double SecondsBetween(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace

Coordinator::Coordinator(CoordinatorSetup setup, LearnerBus& bus, algorithm::Algorithm& algorithm,
                         record::RunRecord& record, Background& background,
                         std::function<TimePoint()> now)
    : setup_(std::move(setup)),
      bus_(bus),
      algorithm_(algorithm),
      record_(record),
      now_(std::move(now)),
      rivals_(setup_.description.learner_id, setup_.rivals, now_()),
      collector_(bus, algorithm, setup_.description, {setup_.rules, setup_.trust, setup_.audit},
                 setup_.canonical_digest, setup_.excluded),
      status_(setup_.status, setup_.description, setup_.rules),
      exclusions_kept_(setup_.excluded.size()),
      version_(algorithm.counters().version),
      steps_(algorithm.counters().steps),
      update_(&algorithm, &background, now_, [&bus] { bus.Wake(); }) {
  if (!setup_.resumed) return;
  saved_version_ = version_;
  status_.Saved(version_);
}

void Coordinator::RequestStop(int signal) {
  stop_signal_ = signal;
  bus_.Wake();
}

int Coordinator::Run() {
  if (const auto refused = AwaitRivals()) return *refused;
  if (!Begin()) return process::kExitFailure;
  Serve();
  WaitForUpdate();
  return End();
}

// Starting: shows itself and waits until nobody else has the run. @return why not to go on.
std::optional<int> Coordinator::AwaitRivals() {
  bus_.Publish(setup_.description);
  while (!rivals_.MayServe(now_())) {
    if (stop_signal_ != 0) return process::kExitSignalBase + stop_signal_;
    if (const auto reason = rivals_.MustStop(now_())) {
      spdlog::error("{}; stop that one first, or give this run another --run NAME", *reason);
      return process::kExitRival;
    }
    const auto event = bus_.Wait(rivals_.NextDeadline(now_()).value_or(now_() + kLongWait));
    if (!event) continue;
    if (const auto* seen = std::get_if<RivalSeen>(&*event)) {
      spdlog::info(
          "another learner of this run is seen (id {}, incarnation {}); waiting whether it lives",
          seen->description.learner_id, seen->description.incarnation);
      rivals_.See(seen->description, now_());
    } else if (const auto* lost = std::get_if<RivalLost>(&*event)) {
      rivals_.Lose(lost->learner_id);
    }
    // Actors that are there already speak again once the description says serving.
  }
  return std::nullopt;
}

// The state is safely on disk before the first assignment.
bool Coordinator::Begin() {
  const checkpoint::TrainState state = CopyState();
  record_.Begin();
  if (!setup_.resumed && !Save(state)) {
    spdlog::error("no checkpoint can be written, so nothing is started");
    return false;
  }
  serving_since_ = now_();
  status_.Begin(state.version, state.steps, setup_.seconds_before, serving_since_);
  rivals_.Serve(serving_since_);
  setup_.description.serving = true;
  bus_.Publish(setup_.description);
  PublishState(setup_.rules.overlap > 0 && version_ > 0);
  next_call_ = serving_since_ + setup_.first_call_for_actors;
  record_.Started(state);
  return true;
}

void Coordinator::PublishState(bool previous_too) {
  const auto publish = [&](PolicySnapshot snapshot) {
    snapshot.incarnation = setup_.description.incarnation;
    bus_.Publish(snapshot);
    collector_.AddSnapshot(std::move(snapshot));
  };
  if (previous_too) publish(algorithm_.PreviousSnapshot());
  publish(algorithm_.Snapshot());
  published_[algorithm_.counters().version] = now_();
  while (published_.size() > 2) published_.erase(published_.begin());
}

void Coordinator::Serve() {
  while (!ending_ && !IsFinished()) {
    ServeOnce();
    if (stop_signal_ != 0) ending_ = process::kExitSignalBase + stop_signal_;
    if (const auto reason = rivals_.MustStop(now_())) {
      spdlog::error("{}; this learner stops", *reason);
      ending_ = process::kExitRival;
    }
  }
}

void Coordinator::ServeOnce() {
  const TimePoint now = now_();
  CallForActors(now);
  if (now >= status_.due()) PublishStatus(StateNow());
  TimePoint deadline = std::min<TimePoint>(now + kLongWait, status_.due());
  for (const auto& due : {collector_.SendAssignments(now), rivals_.NextDeadline(now), next_call_}) {
    if (due) deadline = std::min(deadline, *due);
  }
  if (auto event = bus_.Wait(deadline)) Handle(std::move(*event), now_());
  KeepExclusions(now_());
  FinishUpdateIfDone();
  StartUpdateIfReady();
}

void Coordinator::Handle(LearnerEvent event, TimePoint now) {
  std::visit(
      [&](auto& value) {
        using Type = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<Type, ActorStatus>) {
          collector_.OnStatus(value, now);
        } else if constexpr (std::is_same_v<Type, ActorLost>) {
          collector_.OnLost(value.actor_id, now);
        } else if constexpr (std::is_same_v<Type, EpisodeMessage>) {
          collector_.OnEpisode(std::move(value), now);
        } else if constexpr (std::is_same_v<Type, BadSample>) {
          collector_.OnBadSample(value, now);
        } else if constexpr (std::is_same_v<Type, RivalSeen>) {
          OnRival(value, now);
        } else if constexpr (std::is_same_v<Type, RivalLost>) {
          rivals_.Lose(value.learner_id);
        }
      },
      event);
}

void Coordinator::KeepExclusions(TimePoint now) {
  const collect::trust::ExcludedHosts& excluded = collector_.excluded();
  if (excluded.size() == exclusions_kept_ || now < keep_exclusions_from_) return;
  try {
    record_.Excluded(excluded);
    exclusions_kept_ = excluded.size();
  } catch (const std::exception& failure) {
    keep_exclusions_from_ = now + kExclusionsAgain;
    spdlog::error(
        "that a host is excluded was not written: {}; it is tried again in {} s, and if the "
        "learner starts again before, the host is let in again",
        failure.what(), kExclusionsAgain.count());
  }
}

void Coordinator::OnRival(const RivalSeen& rival, TimePoint now) {
  if (rival.description.serving) {
    spdlog::warn("another learner serves this run too: id {}, incarnation {}, {}",
                 rival.description.learner_id, rival.description.incarnation,
                 rival.description.build);
  }
  rivals_.See(rival.description, now);
}

void Coordinator::CallForActors(TimePoint now) {
  if (!collector_.roster().actors().empty()) {
    next_call_.reset();
    return;
  }
  if (!next_call_) next_call_ = now + setup_.call_for_actors_every;
  if (now < *next_call_) return;
  next_call_ = now + setup_.call_for_actors_every;
  spdlog::info("waiting for actors; start one with: {}", setup_.how_to_join);
}

bool Coordinator::IsFinished() const {
  return version_ >= setup_.rules.updates_total || steps_ >= setup_.total_steps;
}

LearnerStatus::State Coordinator::StateNow() const {
  if (update_.runs()) return LearnerStatus::State::kUpdating;
  return !collector_.roster().actors().empty() ? LearnerStatus::State::kCollecting
                                               : LearnerStatus::State::kWaitingForActors;
}

void Coordinator::PublishStatus(LearnerStatus::State state) {
  const LearnerStatus status = status_.Make(state, collector_, bus_, now_());
  bus_.Publish(status);
  if (setup_.on_status) setup_.on_status(status);
}

void Coordinator::StartUpdateIfReady() {
  if (ending_ || update_.runs() || IsFinished() ||
      collector_.AcceptedOf(version_) < setup_.rules.episodes_per_update) {
    return;
  }
  const TimePoint now = now_();
  const std::uint64_t assignable_since = version_ - std::min(version_, setup_.rules.overlap);
  update_.Start(collector_.Take(version_, now),
                SecondsBetween(published_.lower_bound(assignable_since)->second, now));
}

void Coordinator::FinishUpdateIfDone() {
  const auto outcome = update_.Take();
  if (!outcome) return;
  if (outcome->error) {
    OnUpdateFailed(outcome->error);
    return;
  }
  steps_ = algorithm_.counters().steps;
  collector_.Publish(++version_, *outcome->collected.batch, now_());
  PublishState(false);
  if (!ending_ && !IsFinished()) collector_.SendAssignments(now_());
  const bool milestone = setup_.milestone_every > 0 && version_ % setup_.milestone_every == 0;
  std::optional<checkpoint::TrainState> state;  // to encode it takes a while
  if (version_ % setup_.checkpoint_every == 0 || milestone || IsFinished()) state = CopyState();
  // Actors and the next update go on while the disk is busy.
  StartUpdateIfReady();
  TellLearnt(*outcome);
  TellProgress(*outcome);
  if (state) Save(*state);
}

void Coordinator::OnUpdateFailed(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const algorithm::NonFiniteUpdate& failure) {
    ending_ = process::kExitNonFinite;
    spdlog::error("update to version {} stops the run: {}", version_ + 1, failure.what());
  } catch (const std::exception& failure) {
    ending_ = process::kExitFailure;
    spdlog::error("update to version {} failed: {}", version_ + 1, failure.what());
  }
}

// A running update cannot be cut short; its result is complete, so it is kept.
void Coordinator::WaitForUpdate() {
  while (update_.runs()) {
    bus_.Wait(now_() + kLongWait);
    FinishUpdateIfDone();
  }
}

void Coordinator::TellLearnt(const BackgroundUpdate::Outcome& outcome) {
  const process::CpuTimer timer(process::CpuUse::kSave);
  try {
    record_.Learnt(*outcome.collected.batch);
  } catch (const std::exception& failure) {
    spdlog::error("the replay was not written: {}", failure.what());
  }
}

void Coordinator::TellProgress(const BackgroundUpdate::Outcome& outcome) {
  const process::CpuTimer timer(process::CpuUse::kSave);
  const record::WallReport wall = WallReportOf(outcome);
  status_.Updated(outcome.report, wall);
  try {
    record_.Updated(outcome.report, wall);
  } catch (const std::exception& failure) {
    spdlog::error("the progress of update {} was not written: {}", outcome.report.version,
                  failure.what());
  }
}

record::WallReport Coordinator::WallReportOf(const BackgroundUpdate::Outcome& outcome) {
  const TimePoint now = now_();
  record::WallReport wall;
  wall.seconds = setup_.seconds_before + SecondsBetween(serving_since_, now);
  wall.collect_seconds = outcome.collect_seconds;
  wall.update_seconds = outcome.seconds;
  wall.idle_share = outcome.collected.idle_share;
  wall.bytes_sent = bus_.bytes_sent();
  wall.bytes_received = bus_.bytes_received();
  wall.actors = collector_.roster().actors().size();
  wall.envs = collector_.roster().envs();
  wall.episodes_reassigned = collector_.counts().reassigned;
  return wall;
}

checkpoint::TrainState Coordinator::CopyState() const {
  checkpoint::TrainState state = algorithm_.State();
  state.canonical_digest = collector_.digest();
  return state;
}

bool Coordinator::Save(const checkpoint::TrainState& state) {
  const process::CpuTimer timer(process::CpuUse::kSave);
  try {
    record_.Save(state);
    saved_version_ = state.version;
    status_.Saved(state.version);
    return true;
  } catch (const std::exception& failure) {
    spdlog::error("CHECKPOINT OF VERSION {} NOT WRITTEN: {}; {}", state.version, failure.what(),
                  saved_version_ ? "the one of version " + std::to_string(*saved_version_) +
                                       " is kept: " + record_.LatestCheckpoint()
                                 : "there is none yet");
    return false;
  }
}

// The last complete version is on disk before anything else is said.
int Coordinator::End() {
  const checkpoint::TrainState state = CopyState();
  const bool saved = saved_version_ == state.version || Save(state);
  if (!ending_ && !saved) {
    spdlog::error("the run is finished, but its end is not on disk; make room and use --resume");
    Farewell();
    return process::kExitFailure;
  }
  if (!ending_) return EndFinished(state);
  if (*ending_ > process::kExitSignalBase && !saved)
    ending_ = process::kExitFailure;  // Save has said what is kept
  if (saved) {
    spdlog::info("stopped after update {} of {}; the last good checkpoint is {}", state.version,
                 setup_.status.length.UpdatesAt(state.version, state.steps),
                 record_.LatestCheckpoint());
  }
  if (*ending_ > process::kExitSignalBase) record_.Interrupted(state);
  PublishStatus(LearnerStatus::State::kStopped);
  return *ending_;
}

int Coordinator::EndFinished(const checkpoint::TrainState& state) {
  const bool exact = collector_.Account(version_).exact();
  const std::string accounting = AccountingText();
  if (!exact) spdlog::error("{}", accounting);
  if (const std::string audit = collector_.AuditText(); !audit.empty()) spdlog::info("{}", audit);
  record_.Finished(state, accounting);
  PublishStatus(LearnerStatus::State::kFinished);
  Farewell();
  return exact ? process::kExitFinished : process::kExitFailure;
}

// Actors that know that the run is finished leave by themselves.
void Coordinator::Farewell() {
  setup_.description.finished = true;
  bus_.Publish(setup_.description);
  const TimePoint deadline = now_() + setup_.farewell;
  while (!collector_.roster().actors().empty() && now_() < deadline && stop_signal_ == 0) {
    const auto event = bus_.Wait(deadline);
    if (!event) continue;
    if (const auto* lost = std::get_if<ActorLost>(&*event)) {
      collector_.OnLost(lost->actor_id, now_());
    }
  }
}

std::string Coordinator::AccountingText() const {
  const collect::BatchStore::Accounting accounting = collector_.Account(version_);
  const collect::EpisodeCounts& counts = collector_.counts();
  std::string text = accounting.exact() ? "every episode number entered exactly one update: "
                                        : "NOT every episode number entered exactly one update: ";
  text += std::to_string(accounting.once) + " of " + std::to_string(accounting.total) +
          " (reassigned " + std::to_string(counts.reassigned) + ", duplicates " +
          std::to_string(counts.duplicates) + ", rejected " + std::to_string(counts.rejected);
  if (counts.differing_duplicates > 0) {
    text += ", DIFFERING DUPLICATES " + std::to_string(counts.differing_duplicates);
  }
  if (accounting.before_resume > 0) {
    text += "; " + std::to_string(accounting.before_resume) + " before the last resume";
  }
  return text + ")";
}

}  // namespace metronome::run
