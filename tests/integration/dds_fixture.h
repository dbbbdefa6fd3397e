#pragma once

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "common/dds/dds_bus.h"
#include "common/messages/bus.h"
#include "tests/unit/support/sizes.h"

/// Shared by the tests of the DDS bus: runs that no other test process sees, and waiting for one
/// kind of event.
namespace metronome::test {

using std::chrono::seconds;

/// Long enough for a loaded machine under sanitizers; reached only by a failing test.
inline Clock::time_point Soon() { return Clock::now() + seconds(20); }

/// A run of its own, on loopback, in a domain by process.
inline BusOptions FreshRun(Transport transport = Transport::kUdp) {
  static std::atomic<int> runs{0};
  BusOptions options;
  options.run_name = "test-" + std::to_string(getpid()) + "-" + std::to_string(runs++);
  options.domain = 1 + static_cast<std::uint32_t>(getpid()) % 99;
  options.transport = transport;
  return options;
}

/// The next event of kind Event, others being dropped; std::nullopt at the deadline.
template <class Event, class Bus>
std::optional<Event> Next(Bus& bus, Clock::time_point deadline = Soon()) {
  while (auto event = bus.Wait(deadline)) {
    if (auto* wanted = std::get_if<Event>(&*event)) return std::move(*wanted);
  }
  return std::nullopt;
}

inline ActorStatus SomeStatus(std::uint64_t actor_id) {
  ActorStatus status;
  status.actor_id = actor_id;
  status.incarnation = 3;
  status.host = "somewhere";
  status.pid = 77;
  status.engine = "mujoco-0.0.0";
  status.build = "a compiler and its flags";
  status.canonical_digest = "0123abcd";
  status.envs = 2;
  status.episodes_done = 41;
  status.steps_per_second = 12345.5;
  return status;
}

inline LearnerStatus SomeLearnerStatus(std::uint64_t incarnation, std::size_t actors = 2) {
  LearnerStatus status;
  status.incarnation = incarnation;
  status.learner_id = 100;
  status.run_name = "a-run";
  status.task = "push";
  status.engine = "mujoco-0.0.0";
  status.host = "here";
  status.pid = 78;
  status.state = LearnerStatus::State::kUpdating;
  int next = 1;  // every number differs: none is taken for another
  const auto give = [&next](auto& number) {
    const bool whole = std::is_integral_v<std::remove_reference_t<decltype(number)>>;
    number = static_cast<std::remove_reference_t<decltype(number)>>(next++ + (whole ? 0 : 0.5));
  };
  VisitRunNumbers([&](const StatusNumber&, auto member) { give(status.*member); });
  for (const char* name : {"push", "door-open"}) {
    status.tasks.push_back({.name = name});
    VisitTaskNumbers([&](const StatusNumber&, auto member) { give(status.tasks.back().*member); });
  }
  ActorReport report;
  VisitActorNumbers([&](const StatusNumber&, auto member) { give(report.*member); });
  report.oldest_assignment_seconds = 37.5;
  for (std::size_t i = 0; i < actors; ++i) {
    report.name = "somewhere:" + std::to_string(i);
    report.on_probation = i % 2 == 0;
    report.unanswering = i % 2 == 1;
    status.actors.push_back(report);
  }
  status.actors_total = actors;
  return status;
}

inline RunDescription SomeDescription(std::uint64_t learner_id, const std::string& run_name) {
  RunDescription description;
  description.learner_id = learner_id;
  description.incarnation = 3;
  description.run_name = run_name;
  description.engine = "mujoco-0.0.0";
  description.build = "a compiler and its flags";
  description.config = std::string("binary \0 \xff bytes", 15);
  description.serving = true;
  return description;
}

/// A learner that actors know for one.
inline std::unique_ptr<LearnerBus> ServingLearner(const BusOptions& options) {
  auto learner = dds::MakeDdsLearnerBus(options);
  learner->Publish(SomeDescription(1, options.run_name));
  return learner;
}

inline PolicySnapshot SomeSnapshot(std::uint64_t version, std::size_t parameters = 30000) {
  PolicySnapshot snapshot;
  snapshot.incarnation = 3;
  snapshot.version = version;
  for (std::size_t i = 0; i < parameters; ++i) {
    snapshot.parameters.push_back(0.001f * static_cast<float>(i) - static_cast<float>(version));
  }
  snapshot.observation_mean.assign(kObservationSize, 0.25f);
  snapshot.observation_inv_std.assign(kObservationSize, 4.0f);
  return snapshot;
}

inline EpisodeMessage SomeEpisode(std::uint64_t number, std::size_t steps = 500) {
  EpisodeMessage message;
  message.incarnation = 3;
  message.actor_id = 11;
  Episode& episode = message.episode;
  episode.number = number;
  episode.weights_version = 5;
  for (std::size_t i = 0; i < (steps + 1) * kObservationSize; ++i) {
    episode.observation.push_back(static_cast<float>(i % 977) + static_cast<float>(number));
  }
  episode.action.assign(steps * kActionSize, -0.5f);
  for (std::size_t t = 0; t < steps; ++t) {
    episode.log_prob.push_back(-2.0f - static_cast<float>(t));
    episode.reward.push_back(static_cast<float>(t) / 50);
    episode.head.push_back(static_cast<std::uint16_t>(t * 10 / steps));
    episode.flags.push_back(t + 1 == steps ? kStepTruncated : kStepSuccess);
  }
  return message;
}

inline EpisodeAssignment SomeAssignment(std::uint64_t actor_id, std::uint64_t number) {
  EpisodeAssignment assignment;
  assignment.incarnation = 3;
  assignment.actor_id = actor_id;
  assignment.weights_version = 5;
  assignment.numbers = {number, number + 1};
  return assignment;
}

/// Publishes and waits until the learner knows the actor and assignments can reach it.
inline bool Join(LearnerBus& learner, ActorBus& actor, std::uint64_t actor_id) {
  const Clock::time_point deadline = Soon();
  EpisodeAssignment probe = SomeAssignment(actor_id, 0);
  probe.numbers.clear();
  while (Clock::now() < deadline) {
    actor.Send(SomeStatus(actor_id));
    if (!Next<ActorStatus>(learner, Clock::now() + std::chrono::milliseconds(200))) continue;
    if (!learner.Send(probe)) continue;
    return Next<EpisodeAssignment>(actor, deadline).has_value();
  }
  return false;
}

}  // namespace metronome::test
