#include "common/checkpoint/checkpoint.h"

#include <bit>
#include <cstring>

#include "common/checkpoint/old_config.h"
#include "common/checkpoint/repeated_field.h"
#include "common/config/config.h"
#include "common/policy/network.h"
#include "common/policy/snapshot.h"
#include "common/process/sha256.h"
#include "common/schema/checkpoint.pb.h"
#include "common/text/number_text.h"

namespace metronome::checkpoint {
namespace {

static_assert(std::endian::native == std::endian::little, "the frame is copied as it lies");

constexpr std::string_view kMagic = "METRCKPT";
constexpr std::uint32_t kLastFormatOfPpoAlone = 5;
constexpr std::uint32_t kLastFormatOfOtherNumbers = 6;
constexpr std::uint32_t kLastFormatOfOtherDefaults = 7;
constexpr std::size_t kVersionAt = 8, kLengthAt = 12, kDigestAt = 20, kPayloadAt = 52;

void ToPayload(const TrainState& state, CheckpointPayload& payload) {
  payload.set_version(state.version);
  payload.set_steps(state.steps);
  payload.set_episodes_used(state.episodes_used);
  payload.set_canonical_digest(state.canonical_digest);
  PolicyPayload& policy = *payload.mutable_policy();
  const PolicySnapshot& snapshot = state.policy;
  policy.mutable_parameters()->Assign(snapshot.parameters.begin(), snapshot.parameters.end());
  policy.mutable_observation_mean()->Assign(snapshot.observation_mean.begin(),
                                            snapshot.observation_mean.end());
  policy.mutable_observation_inv_std()->Assign(snapshot.observation_inv_std.begin(),
                                               snapshot.observation_inv_std.end());
  payload.mutable_weights()->set_count(state.weights.count);
  payload.mutable_weights()->set_sha256(state.weights.sha256);
  payload.mutable_algorithm()->set_name(state.algorithm.name);
  payload.mutable_algorithm()->set_format(state.algorithm.format);
  payload.mutable_algorithm()->set_state(state.algorithm.bytes);
}

TrainState StateOf(const CheckpointPayload& payload) {
  TrainState state;
  state.version = payload.version();
  state.steps = payload.steps();
  state.episodes_used = payload.episodes_used();
  state.canonical_digest = payload.canonical_digest();
  state.policy.version = payload.version();
  state.policy.parameters = FromField(payload.policy().parameters());
  state.policy.observation_mean = FromField(payload.policy().observation_mean());
  state.policy.observation_inv_std = FromField(payload.policy().observation_inv_std());
  state.weights = {payload.weights().count(), payload.weights().sha256()};
  state.algorithm = {payload.algorithm().name(), payload.algorithm().format(),
                     payload.algorithm().state()};
  return state;
}

std::string SerialisePayload(const Checkpoint& checkpoint) {
  CheckpointPayload payload;
  *payload.mutable_config() = checkpoint.config;
  ToPayload(checkpoint.state, payload);
  payload.set_engine(checkpoint.engine);
  payload.set_build(checkpoint.build);
  payload.set_isa(checkpoint.isa);
  payload.set_incarnation(checkpoint.incarnation);
  payload.set_progress_bytes(checkpoint.logs.progress_bytes);
  payload.set_events_bytes(checkpoint.logs.events_bytes);
  payload.set_wall_seconds(checkpoint.logs.wall_seconds);
  if (checkpoint.replay != ReplayPosition()) {
    payload.mutable_replay()->set_first(checkpoint.replay.first);
    payload.mutable_replay()->set_next(checkpoint.replay.next);
    payload.mutable_replay()->set_sha256(checkpoint.replay.sha256);
  }
  if (!checkpoint.initial_weights_sha256.empty()) {
    payload.set_initial_weights_sha256(checkpoint.initial_weights_sha256);
  }
  return payload.SerializeAsString();
}

template <typename T>
void Put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

template <typename T>
T Get(std::string_view bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

process::Sha256Digest DigestOf(std::string_view frame, std::string_view payload) {
  std::string covered(frame.substr(0, kDigestAt));
  covered.append(payload);
  return process::Sha256(covered);
}

struct Frame {
  std::uint32_t format = 0;
  std::string_view payload;
};

/// @return what is in a file whose every byte is as it was written.
Frame CheckFrame(std::string_view bytes, const std::string& name) {
  if (bytes.size() < kPayloadAt || bytes.substr(0, kMagic.size()) != kMagic) {
    throw CheckpointDamaged(name + ": not a Metronome checkpoint (damaged at its start, or " +
                            "something else altogether; " + std::to_string(bytes.size()) +
                            " bytes)");
  }
  const auto length = Get<std::uint64_t>(bytes, kLengthAt);
  const std::string_view payload = bytes.substr(kPayloadAt);
  const process::Sha256Digest digest = DigestOf(bytes, payload);
  if (std::memcmp(digest.data(), bytes.data() + kDigestAt, digest.size()) != 0) {
    throw CheckpointDamaged(name + ": damaged: " +
                            (length == payload.size() ? "its SHA-256 does not match its content"
                                                      : "it should hold " + std::to_string(length) +
                                                            " bytes of payload and holds " +
                                                            std::to_string(payload.size())));
  }
  const auto format = Get<std::uint32_t>(bytes, kVersionAt);
  if (format < kOldestCheckpointFormat || format > kCheckpointFormat) {
    throw CheckpointError(name + ": checkpoint format " + std::to_string(format) +
                          ", this build reads formats " + std::to_string(kOldestCheckpointFormat) +
                          " to " + std::to_string(kCheckpointFormat) +
                          "; use a build that knows it");
  }
  return {format, payload};
}

void RequireSize(std::size_t size, std::size_t wanted, const std::string& what,
                 const std::string& name) {
  if (size == wanted) return;
  throw CheckpointError(name + ": another shape: " + what + " has " + std::to_string(size) +
                        " numbers, its configuration asks for " + std::to_string(wanted));
}

/// Counters, policy and algorithm of what formats 1 to 5 kept of a run. @param config  valid.
TrainState StateOfOldFormat(const std::string& bytes, const RunConfig& config,
                            const std::string& name) {
  StateOfFormat5 old;
  if (!old.ParseFromString(bytes))
    throw CheckpointError(name + ": its state is not a checkpoint's");
  const std::vector<float> parameters = FromField(old.parameters());
  const policy::RunningStatistics observation{FromField(old.observation().mean()),
                                              FromField(old.observation().m2()),
                                              old.observation().count()};
  RequireSize(parameters.size(), policy::ParameterCount(policy::ShapeOf(config)), "the network",
              name);
  if (observation.count > 0) {
    const auto observations = static_cast<std::size_t>(policy::ShapeOf(config).observation);
    RequireSize(observation.mean.size(), observations, "the observation statistics", name);
    RequireSize(observation.m2.size(), observations, "the observation statistics", name);
  }
  TrainState state;
  state.version = old.version();
  state.steps = old.steps();
  state.episodes_used = old.episodes_used();
  state.policy = policy::MakeSnapshot(state.version, parameters.data(), {observation}, config);
  state.weights = {parameters.size(), process::WeightsSha256(parameters)};
  state.algorithm = {"ppo", 1, bytes};
  return state;
}

void RequireValid(const RunConfig& config, const std::string& name) {
  try {
    config::Validate(config);
  } catch (const config::ConfigError& error) {
    throw CheckpointError(name + ": its configuration is not valid: " + error.what());
  }
}

void RequireFit(const PolicySnapshot& policy, const RunConfig& config, const std::string& name) {
  RequireSize(policy.parameters.size(), policy::ActorLayout(policy::ShapeOf(config)).size,
              "the policy", name);
  const std::size_t observations = policy::ShapeOf(config).statistics();
  RequireSize(policy.observation_mean.size(), observations, "the observations' mean", name);
  RequireSize(policy.observation_inv_std.size(), observations, "the observations' scale", name);
}

void Complete(RunConfig& config, const std::string& name, const config::SpecSource& source) {
  try {
    config::CompleteSpec(config, source);
  } catch (const config::ConfigError& error) {
    throw CheckpointError(name + ": " + error.what());
  }
}

std::string ShapeText(const RunConfig& config) {
  const policy::NetworkShape shape = policy::ShapeOf(config);
  std::string text = std::to_string(shape.input()) + " inputs, hidden";
  for (const auto width : shape.hidden) text += " " + std::to_string(width);
  return text + ", " + text::Counted(shape.heads, "head") + " of " + std::to_string(shape.action) +
         ", " + std::to_string(shape.critic_heads) + " of the critic of " +
         text::Counted(std::uint64_t(shape.values), "value");
}

}  // namespace

std::string EncodeCheckpoint(const Checkpoint& checkpoint) {
  const std::string payload = SerialisePayload(checkpoint);
  std::string bytes(kMagic);
  Put(bytes, kCheckpointFormat);
  Put(bytes, static_cast<std::uint64_t>(payload.size()));
  const process::Sha256Digest digest = DigestOf(bytes, payload);
  bytes.append(reinterpret_cast<const char*>(digest.data()), digest.size());
  return bytes + payload;
}

Checkpoint DecodeCheckpoint(std::string_view bytes, const std::string& name,
                            const config::SpecSource& source) {
  const auto [format, raw] = CheckFrame(bytes, name);
  CheckpointPayload payload;
  if (raw.size() > INT32_MAX || !payload.ParseFromArray(raw.data(), static_cast<int>(raw.size()))) {
    throw CheckpointError(name + ": its payload is not a checkpoint's");
  }
  Checkpoint checkpoint;
  checkpoint.config = payload.config();
  if (format <= kLastFormatOfOtherDefaults) CompleteOldConfig(checkpoint.config);
  Complete(checkpoint.config, name, source);
  RequireValid(checkpoint.config, name);
  checkpoint.state = format <= kLastFormatOfPpoAlone
                         ? StateOfOldFormat(payload.state_of_format_5(), checkpoint.config, name)
                         : StateOf(payload);
  // No actor of this build could bring it again.
  if (format <= kLastFormatOfOtherNumbers) checkpoint.state.canonical_digest.clear();
  RequireFit(checkpoint.state.policy, checkpoint.config, name);
  checkpoint.engine = payload.engine();
  checkpoint.build = payload.build();
  checkpoint.isa = payload.isa();
  checkpoint.incarnation = payload.incarnation();
  checkpoint.logs = {payload.progress_bytes(), payload.events_bytes(), payload.wall_seconds()};
  checkpoint.replay = {payload.replay().first(), payload.replay().next(),
                       payload.replay().sha256()};
  checkpoint.initial_weights_sha256 = payload.initial_weights_sha256();
  return checkpoint;
}

Checkpoint PolicyAlone(Checkpoint checkpoint) {
  checkpoint.state.algorithm = {checkpoint.state.algorithm.name, kPolicyAlone, ""};
  checkpoint.state.canonical_digest.clear();
  checkpoint.logs = {};
  return checkpoint;
}

void RequireState(const Checkpoint& checkpoint, const std::string& name) {
  if (checkpoint.state.algorithm.format != kPolicyAlone) return;
  throw CheckpointError(name + ": it holds a policy by itself, to be evaluated and drawn: no run " +
                        "goes on from it or begins with it; that takes a checkpoint of its run");
}

void RequireShape(const Checkpoint& checkpoint, const RunConfig& config, const std::string& name) {
  if (policy::ShapeOf(checkpoint.config) == policy::ShapeOf(config)) return;
  throw CheckpointError(name + ": another network shape: it holds " + ShapeText(checkpoint.config) +
                        "; asked for is " + ShapeText(config));
}

}  // namespace metronome::checkpoint
