#include "common/dds/convert.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>
#include <utility>

namespace metronome::dds {
namespace {

static_assert(std::endian::native == std::endian::little, "the checksum is over native bytes");
static_assert(wire::kMaxSteps == kMaxSteps);
static_assert(wire::kMaxObservationSize == kMaxObservationSize);
static_assert(wire::kMaxActionSize == kMaxActionSize);
static_assert(wire::kMaxObservations == (kMaxSteps + 1) * kMaxObservationSize);
static_assert(wire::kMaxActions == kMaxSteps * kMaxActionSize);

constexpr std::uint32_t kMaxEnvs = 4096;  // an actor with more is lying

void CheckAtMost(std::size_t size, std::size_t bound, const std::string& field) {
  if (size <= bound) return;
  throw Malformed(field + " has " + std::to_string(size) + " elements, the wire carries at most " +
                  std::to_string(bound));
}

/// `rows` rows of one size, from 1 to `most`. How large they are is for the run's specification.
void CheckRows(std::size_t size, std::size_t rows, std::size_t most, const std::string& field) {
  if (size > 0 && size % rows == 0 && size / rows <= most) return;
  throw Malformed(field + " has " + std::to_string(size) + " elements, which make no " +
                  std::to_string(rows) + " rows of 1 to " + std::to_string(most));
}

void CheckExactly(std::size_t size, std::size_t expected, const std::string& field) {
  if (size == expected) return;
  throw Malformed(field + " has " + std::to_string(size) + " elements instead of " +
                  std::to_string(expected));
}

template <class FixedString>
void CopyText(const std::string& text, const std::string& field, FixedString* out) {
  CheckAtMost(text.size(), FixedString::max_size, field);
  *out = text;
}

void CheckSnapshotSizes(std::size_t parameters, std::size_t mean, std::size_t inv_std) {
  CheckAtMost(parameters, wire::kMaxParameters, "parameters");
  CheckAtMost(mean, wire::kMaxNormaliser, "observation_mean");
  CheckExactly(inv_std, mean, "observation_inv_std");
}

/// Every array against the number of rewards, which is T. The sizes that the run's configuration
/// asks for are the learner's to check.
void CheckEpisodeSizes(const Episode& episode) {
  const std::size_t steps = episode.reward.size();
  if (steps == 0) throw Malformed("reward is empty: an episode has at least one step");
  CheckAtMost(steps, wire::kMaxSteps, "reward");
  CheckRows(episode.observation.size(), steps + 1, kMaxObservationSize, "observation");
  CheckRows(episode.action.size(), steps, kMaxActionSize, "action");
  CheckExactly(episode.log_prob.size(), steps, "log_prob");
  CheckExactly(episode.head.size(), steps, "head");
  CheckExactly(episode.flags.size(), steps, "flags");
}

// A field of a status to the wire and back.

template <class T>
void CopyField(const T& field, const char*, T* out) {
  *out = field;
}

template <std::size_t Size>
void CopyField(const std::string& field, const char* name,
               eprosima::fastrtps::fixed_string<Size>* out) {
  CopyText(field, name, out);
}

template <std::size_t Size>
void CopyField(const eprosima::fastrtps::fixed_string<Size>& field, const char*, std::string* out) {
  *out = field.to_string();
}

void CopyField(const LearnerState& field, const char*, std::uint8_t* out) {
  *out = static_cast<std::uint8_t>(field);
}

void CopyField(const std::uint8_t& field, const char* name, LearnerState* out) {
  if (field > static_cast<std::uint8_t>(LearnerState::kStopped)) {
    throw Malformed(name + (" " + std::to_string(field)) + " of learner is unknown");
  }
  *out = static_cast<LearnerState>(field);
}

#define METRONOME_TO_WIRE(type, name, ...) CopyField(message.name, #name, &sample.name());
#define METRONOME_FROM_WIRE(type, name, ...) CopyField(sample.name(), #name, &message.name);

wire::ActorReport ToWire(const ActorReport& message) {
  wire::ActorReport sample;
  CopyText(message.name, "name of an actor", &sample.name());
  METRONOME_ACTOR_NUMBERS(METRONOME_TO_WIRE)
  return sample;
}

ActorReport FromWire(const wire::ActorReport& sample) {
  ActorReport message;
  message.name = sample.name().to_string();
  METRONOME_ACTOR_NUMBERS(METRONOME_FROM_WIRE)
  return message;
}

wire::TaskStatus ToWire(const TaskStatus& message) {
  wire::TaskStatus sample;
  CopyText(message.name, "name of a task", &sample.name());
  METRONOME_TASK_NUMBERS(METRONOME_TO_WIRE)
  return sample;
}

TaskStatus FromWire(const wire::TaskStatus& sample) {
  TaskStatus message;
  message.name = sample.name().to_string();
  METRONOME_TASK_NUMBERS(METRONOME_FROM_WIRE)
  return message;
}

}  // namespace

std::uint32_t SnapshotChecksum(const PolicySnapshot& snapshot) {
  uLong crc = crc32(0, nullptr, 0);
  const auto add = [&crc](const void* data, std::size_t bytes) {
    // A null pointer, which empty arrays may have, would mean "start anew" to zlib.
    if (bytes > 0) crc = crc32_z(crc, static_cast<const Bytef*>(data), bytes);
  };
  add(&snapshot.version, sizeof snapshot.version);
  for (const auto* array :
       {&snapshot.parameters, &snapshot.observation_mean, &snapshot.observation_inv_std}) {
    add(array->data(), array->size() * sizeof(float));
  }
  return static_cast<std::uint32_t>(crc);
}

wire::RunDescription ToWire(const RunDescription& message) {
  CheckAtMost(message.config.size(), wire::kMaxConfigBytes, "config");
  wire::RunDescription sample;
  sample.protocol_version(message.protocol_version);
  sample.incarnation(message.incarnation);
  sample.learner_id(message.learner_id);
  CopyText(message.run_name, "run_name", &sample.run_name());
  CopyText(message.engine, "engine", &sample.engine());
  CopyText(message.build, "build", &sample.build());
  sample.config().assign(message.config.begin(), message.config.end());
  sample.serving(message.serving);
  sample.finished(message.finished);
  return sample;
}

RunDescription FromWire(const wire::RunDescription& sample) {
  CheckAtMost(sample.config().size(), wire::kMaxConfigBytes, "config");
  RunDescription message;
  message.protocol_version = sample.protocol_version();
  message.incarnation = sample.incarnation();
  message.learner_id = sample.learner_id();
  message.run_name = sample.run_name().to_string();
  message.engine = sample.engine().to_string();
  message.build = sample.build().to_string();
  message.config.assign(sample.config().begin(), sample.config().end());
  message.serving = sample.serving();
  message.finished = sample.finished();
  return message;
}

wire::PolicySnapshot ToWire(PolicySnapshot message) {
  CheckSnapshotSizes(message.parameters.size(), message.observation_mean.size(),
                     message.observation_inv_std.size());
  wire::PolicySnapshot sample;
  sample.protocol_version(kProtocolVersion);
  sample.incarnation(message.incarnation);
  sample.version(message.version);
  sample.checksum(SnapshotChecksum(message));
  sample.parameters(std::move(message.parameters));
  sample.observation_mean(std::move(message.observation_mean));
  sample.observation_inv_std(std::move(message.observation_inv_std));
  return sample;
}

PolicySnapshot FromWire(wire::PolicySnapshot sample) {
  CheckSnapshotSizes(sample.parameters().size(), sample.observation_mean().size(),
                     sample.observation_inv_std().size());
  PolicySnapshot message;
  message.incarnation = sample.incarnation();
  message.version = sample.version();
  message.parameters = std::move(sample.parameters());
  message.observation_mean = std::move(sample.observation_mean());
  message.observation_inv_std = std::move(sample.observation_inv_std());
  if (SnapshotChecksum(message) != sample.checksum()) {
    throw Malformed("checksum of version " + std::to_string(message.version) + " does not hold");
  }
  return message;
}

wire::EpisodeAssignment ToWire(const EpisodeAssignment& message) {
  CheckAtMost(message.numbers.size(), wire::kMaxAssignedNumbers, "numbers");
  wire::EpisodeAssignment sample;
  sample.protocol_version(kProtocolVersion);
  sample.incarnation(message.incarnation);
  sample.actor_id(message.actor_id);
  sample.kind(static_cast<std::uint8_t>(message.kind));
  sample.weights_version(message.weights_version);
  sample.numbers(message.numbers);
  CopyText(message.reason, "reason", &sample.reason());
  return sample;
}

EpisodeAssignment FromWire(const wire::EpisodeAssignment& sample) {
  CheckAtMost(sample.numbers().size(), wire::kMaxAssignedNumbers, "numbers");
  if (sample.kind() > static_cast<std::uint8_t>(EpisodeAssignment::Kind::kRefuse)) {
    throw Malformed("kind " + std::to_string(sample.kind()) + " of assignment is unknown");
  }
  EpisodeAssignment message;
  message.incarnation = sample.incarnation();
  message.actor_id = sample.actor_id();
  message.kind = static_cast<EpisodeAssignment::Kind>(sample.kind());
  message.weights_version = sample.weights_version();
  message.numbers = sample.numbers();
  message.reason = sample.reason().to_string();
  return message;
}

wire::Episode ToWire(EpisodeMessage message) {
  Episode& episode = message.episode;
  CheckEpisodeSizes(episode);
  wire::Episode sample;
  sample.protocol_version(kProtocolVersion);
  sample.incarnation(message.incarnation);
  sample.actor_id(message.actor_id);
  sample.number(episode.number);
  sample.weights_version(episode.weights_version);
  sample.observation(std::move(episode.observation));
  sample.action(std::move(episode.action));
  sample.log_prob(std::move(episode.log_prob));
  sample.reward(std::move(episode.reward));
  sample.head(std::move(episode.head));
  sample.flags(std::move(episode.flags));
  return sample;
}

EpisodeMessage FromWire(wire::Episode sample) {
  EpisodeMessage message;
  message.incarnation = sample.incarnation();
  message.actor_id = sample.actor_id();
  Episode& episode = message.episode;
  episode.number = sample.number();
  episode.weights_version = sample.weights_version();
  episode.observation = std::move(sample.observation());
  episode.action = std::move(sample.action());
  episode.log_prob = std::move(sample.log_prob());
  episode.reward = std::move(sample.reward());
  episode.head = std::move(sample.head());
  episode.flags = std::move(sample.flags());
  CheckEpisodeSizes(episode);
  return message;
}

wire::ActorStatus ToWire(const ActorStatus& message) {
  wire::ActorStatus sample;
  sample.protocol_version(message.protocol_version);
  sample.incarnation(message.incarnation);
  sample.actor_id(message.actor_id);
  CopyText(message.host, "host", &sample.host());
  sample.pid(message.pid);
  CopyText(message.engine, "engine", &sample.engine());
  CopyText(message.build, "build", &sample.build());
  CopyText(message.canonical_digest, "canonical_digest", &sample.canonical_digest());
  sample.envs(message.envs);
  sample.episodes_done(message.episodes_done);
  sample.steps_per_second(message.steps_per_second);
  return sample;
}

ActorStatus FromWire(const wire::ActorStatus& sample) {
  if (!std::isfinite(sample.steps_per_second()) || sample.steps_per_second() < 0) {
    throw Malformed("steps_per_second is not a rate");
  }
  CheckAtMost(sample.envs(), kMaxEnvs, "envs");
  ActorStatus message;
  message.protocol_version = sample.protocol_version();
  message.actor_id = sample.actor_id();
  message.incarnation = sample.incarnation();
  message.host = sample.host().to_string();
  message.pid = sample.pid();
  message.engine = sample.engine().to_string();
  message.build = sample.build().to_string();
  message.canonical_digest = sample.canonical_digest().to_string();
  message.envs = sample.envs();
  message.episodes_done = sample.episodes_done();
  message.steps_per_second = sample.steps_per_second();
  return message;
}

wire::LearnerStatus ToWire(const LearnerStatus& message) {
  wire::LearnerStatus sample;
  sample.protocol_version(kProtocolVersion);
  METRONOME_LEARNER_IDENTITY(METRONOME_TO_WIRE)
  METRONOME_RUN_NUMBERS(METRONOME_TO_WIRE)
  CheckAtMost(message.tasks.size(), wire::kMaxTasks, "tasks");
  for (const TaskStatus& task : message.tasks) sample.tasks().push_back(ToWire(task));
  // More are counted in actors_total, not listed.
  const std::size_t listed = std::min<std::size_t>(message.actors.size(), wire::kMaxActorReports);
  for (std::size_t i = 0; i < listed; ++i) sample.actors().push_back(ToWire(message.actors[i]));
  return sample;
}

LearnerStatus FromWire(const wire::LearnerStatus& sample) {
  CheckAtMost(sample.tasks().size(), wire::kMaxTasks, "tasks");
  CheckAtMost(sample.actors().size(), wire::kMaxActorReports, "actors");
  LearnerStatus message;
  METRONOME_LEARNER_IDENTITY(METRONOME_FROM_WIRE)
  METRONOME_RUN_NUMBERS(METRONOME_FROM_WIRE)
  for (const wire::TaskStatus& task : sample.tasks()) message.tasks.push_back(FromWire(task));
  for (const wire::ActorReport& actor : sample.actors()) message.actors.push_back(FromWire(actor));
  return message;
}

}  // namespace metronome::dds
