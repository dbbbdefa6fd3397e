#pragma once

#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "learner/algorithm/algorithm.h"
#include "learner/run/coordinator.h"
#include "tests/unit/support/fake_bus.h"

/// A run in miniature around the real coordinator: the mathematics, the disk and the actors are
/// fakes.
namespace metronome::testing {

using std::chrono::milliseconds;

/// An "algorithm" that counts versions and keeps the numbers it was given.
class FakeAlgorithm final : public algorithm::Algorithm {
 public:
  [[nodiscard]] const checkpoint::RunCounters& counters() const override { return current; }
  algorithm::UpdateReport Update(const std::vector<Episode>& batch) override {
    if (fail_at == current.version + 1) throw algorithm::NonFiniteUpdate("the loss is nan");
    for (const Episode& episode : batch) {
      learnt.push_back(episode.number);
      behaviour.push_back(episode.weights_version);
      rewards.push_back(episode.reward.at(0));
    }
    ++current.version;
    current.steps += batch.size() * 10;
    algorithm::UpdateReport report;
    static_cast<checkpoint::RunCounters&>(report) = current;
    return report;
  }
  [[nodiscard]] checkpoint::TrainState State() const override {
    checkpoint::TrainState state;
    static_cast<checkpoint::RunCounters&>(state) = current;
    return state;
  }
  [[nodiscard]] PolicySnapshot Snapshot() const override { return Make(current.version); }
  [[nodiscard]] PolicySnapshot PreviousSnapshot() const override {
    return Make(current.version - 1);
  }
  [[nodiscard]] std::optional<std::string> Check(const Episode& episode,
                                                 const PolicySnapshot& snapshot) const override {
    if (episode.weights_version != snapshot.version) return "another version";
    if (std::isnan(episode.reward.at(0))) return "a reward is not finite";
    return std::nullopt;
  }
  [[nodiscard]] std::vector<algorithm::Metric> Metrics() const override { return {}; }

  checkpoint::RunCounters current;
  std::uint64_t fail_at = 0;
  std::vector<std::uint64_t> learnt;
  std::vector<std::uint64_t> behaviour;
  std::vector<float> rewards;

 private:
  static PolicySnapshot Make(std::uint64_t version) {
    PolicySnapshot snapshot;
    snapshot.version = version;
    return snapshot;
  }
};

/// A "disk" that remembers what happened, and may be full.
class FakeRecord final : public record::RunRecord {
 public:
  explicit FakeRecord(const FakeBus& bus) : bus_(bus) {}

  void Begin() override { begun = true; }
  std::string Save(const checkpoint::TrainState& state) override {
    if (full && full(state.version)) {
      throw std::system_error(ENOSPC, std::generic_category(), "checkpoint");
    }
    saved.push_back(state);
    assignments_before_save.push_back(bus_.assignments.size());
    return "checkpoint";
  }
  [[nodiscard]] std::string LatestCheckpoint() const override { return "checkpoint"; }
  void Started(const checkpoint::TrainState& state) override { started_at = state.version; }
  void Excluded(const collect::trust::ExcludedHosts& hosts) override {
    if (exclusions_to_fail > 0) {
      --exclusions_to_fail;
      throw std::system_error(ENOSPC, std::generic_category(), "excluded.json");
    }
    excluded = hosts;
  }
  void Learnt(const std::vector<Episode>& batch) override { learnt += batch.size(); }
  void Updated(const algorithm::UpdateReport& report, const record::WallReport& wall) override {
    walls.push_back(wall);
    updates.push_back(report.version);
  }
  void Finished(const checkpoint::TrainState&, const std::string& accounting) override {
    finished = accounting;
  }
  void Interrupted(const checkpoint::TrainState&) override { interrupted = true; }

  std::function<bool(std::uint64_t version)> full;
  bool begun = false;
  bool interrupted = false;
  std::optional<std::uint64_t> started_at;
  collect::trust::ExcludedHosts excluded;
  int exclusions_to_fail = 0;
  std::vector<checkpoint::TrainState> saved;
  std::vector<std::size_t> assignments_before_save;
  std::size_t learnt = 0;  // episodes
  std::vector<std::uint64_t> updates;
  std::vector<record::WallReport> walls;
  std::string finished;

 private:
  const FakeBus& bus_;
};

struct FakeActor {
  ActorStatus status;
  milliseconds duration{100};
  /// The messages that it sends for an assignment; default: the episode, once.
  std::function<std::vector<EpisodeMessage>(const EpisodeMessage&)> answer;
  Clock::time_point busy_until;
  std::string refused;  // reason
  bool alive = true;
};

/// All of it together. Actors join when the description says serving and leave when it is finished.
class FakeRun {
 public:
  static constexpr std::uint64_t kIncarnation = 7;
  static constexpr std::uint64_t kLearnerId = 100;

  FakeRun() : background(bus), record(bus) {
    setup.description.learner_id = kLearnerId;
    setup.description.incarnation = kIncarnation;
    setup.description.run_name = "test";
    setup.description.engine = "engine-1";
    setup.description.build = "build-1";
    setup.rules.episodes_per_update = 4;
    setup.rules.updates_total = 3;
    setup.how_to_join = "metronome-actor run --run test";
    bus.on_assignment = [this](const EpisodeAssignment& assignment) { return Obey(assignment); };
    bus.on_description = [this](const RunDescription& description) { Hear(description); };
  }

  FakeActor& AddActor(std::uint64_t id, std::uint32_t envs = 1) {
    FakeActor& actor = actors[id];
    actor.status.actor_id = id;
    actor.status.incarnation = kIncarnation;
    actor.status.host = "host" + std::to_string(id);
    actor.status.vouched_host = actor.status.host;
    actor.status.engine = "engine-1";
    actor.status.build = "build-1";
    actor.status.canonical_digest = "digest-1";
    actor.status.envs = envs;
    return actor;
  }

  void Resume(std::uint64_t version) {
    setup.resumed = true;
    setup.rules.first_version = version;
    learning.current.version = version;
    setup.canonical_digest = "digest-1";
  }

  int Run() {
    coordinator = std::make_unique<run::Coordinator>(setup, bus, learning, record, background,
                                                     [this] { return bus.now(); });
    return coordinator->Run();
  }

  void Kill(std::uint64_t id) {
    actors.at(id).alive = false;
    bus.After(milliseconds(0), ActorLost{id});
  }

  static Episode MakeEpisode(std::uint64_t number, std::uint64_t version) {
    Episode episode;
    episode.number = number;
    episode.weights_version = version;
    episode.reward = {float(number)};
    return episode;
  }

  run::CoordinatorSetup setup;
  FakeBus bus;
  FakeBackground background;
  FakeAlgorithm learning;
  FakeRecord record;
  std::map<std::uint64_t, FakeActor> actors;
  std::unique_ptr<run::Coordinator> coordinator;

 private:
  bool Obey(const EpisodeAssignment& assignment) {
    const auto found = actors.find(assignment.actor_id);
    if (found == actors.end() || !found->second.alive) return false;
    FakeActor& actor = found->second;
    if (assignment.kind == EpisodeAssignment::Kind::kRefuse) {
      actor.refused = assignment.reason;
      return true;
    }
    for (const std::uint64_t number : assignment.numbers) {
      actor.busy_until = std::max(actor.busy_until, bus.now()) + actor.duration;
      const EpisodeMessage message{kIncarnation, assignment.actor_id,
                                   MakeEpisode(number, assignment.weights_version)};
      const auto wait = std::chrono::duration_cast<milliseconds>(actor.busy_until - bus.now());
      bus.CallAfter(wait, [this, &actor, message] {
        if (!actor.alive) return;
        for (auto& sent : actor.answer ? actor.answer(message) : std::vector{message}) {
          bus.After(milliseconds(0), std::move(sent));
        }
      });
    }
    return true;
  }

  void Hear(const RunDescription& description) {
    for (auto& [id, actor] : actors) {
      if (!actor.alive) continue;
      if (description.serving && !description.finished) bus.After(milliseconds(1), actor.status);
      if (description.finished) bus.After(milliseconds(50), ActorLost{id});
    }
  }
};

}  // namespace metronome::testing
