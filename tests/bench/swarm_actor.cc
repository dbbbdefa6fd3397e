#include "tests/bench/swarm_actor.h"

#include <unistd.h>

#include <chrono>
#include <utility>
#include <variant>

#include "common/dds/dds_bus.h"

namespace metronome::bench {
namespace {

constexpr std::size_t kSnapshotsKept = 3;
constexpr std::chrono::seconds kStatusEvery{1};

}  // namespace

SimulatedActor::SimulatedActor(const BusOptions& bus, std::uint64_t actor_id, std::uint32_t envs,
                               const EpisodeBank& bank)
    : actor_id_(actor_id), envs_(envs), bank_(bank), bus_(dds::MakeDdsActorBus(bus, actor_id)) {}

void SimulatedActor::Run() {
  while (!over_) {
    if (learner_ && Clock::now() >= next_status_) SendStatus();
    if (auto event = bus_->Wait(Clock::now() + kStatusEvery)) Handle(*event);
    AnswerReady();
  }
  bus_->Close(std::chrono::milliseconds(500));
}

void SimulatedActor::Handle(ActorEvent& event) {
  if (auto* description = std::get_if<RunDescription>(&event)) {
    over_ = description->finished;
    if (!description->serving || learner_) return;
    learner_ = std::move(*description);
    SendStatus();
  } else if (auto* snapshot = std::get_if<PolicySnapshot>(&event)) {
    snapshots_.insert_or_assign(snapshot->version, std::move(*snapshot));
    if (snapshots_.size() > kSnapshotsKept) snapshots_.erase(snapshots_.begin());
  } else if (auto* assignment = std::get_if<EpisodeAssignment>(&event)) {
    over_ = over_ || assignment->kind == EpisodeAssignment::Kind::kRefuse;
    waiting_.push_back(std::move(*assignment));
  } else if (std::holds_alternative<LearnerLost>(event)) {
    over_ = learner_.has_value();
  }
}

void SimulatedActor::SendStatus() {
  ActorStatus status;
  status.actor_id = actor_id_;
  status.incarnation = learner_->incarnation;
  status.host = "swarm";
  status.pid = static_cast<std::uint32_t>(getpid());
  status.engine = learner_->engine;
  status.build = "simulated";
  status.canonical_digest = "simulated";
  status.envs = envs_;
  status.episodes_done = sent_;
  bus_->Send(status);
  next_status_ = Clock::now() + kStatusEvery;
}

void SimulatedActor::AnswerReady() {
  for (const EpisodeAssignment& assignment : std::exchange(waiting_, {})) {
    const auto snapshot = snapshots_.find(assignment.weights_version);
    if (snapshot == snapshots_.end()) {
      waiting_.push_back(assignment);
      continue;
    }
    for (const std::uint64_t number : assignment.numbers) Answer(number, snapshot->second);
  }
}

void SimulatedActor::Answer(std::uint64_t number, const PolicySnapshot& snapshot) {
  EpisodeMessage message;
  message.incarnation = learner_->incarnation;
  message.actor_id = actor_id_;
  message.episode = bank_.Make(number, snapshot);
  if (bus_->Send(std::move(message)) == ActorBus::SendResult::kSent) ++sent_;
  if (Clock::now() >= next_status_) SendStatus();
}

}  // namespace metronome::bench
