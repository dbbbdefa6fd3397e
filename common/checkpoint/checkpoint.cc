#include "common/checkpoint/checkpoint.h"

#include <bit>
#include <cstring>

#include "common/config/config.h"
#include "common/messages/episode.h"
#include "common/policy/network.h"
#include "common/process/sha256.h"
#include "common/schema/checkpoint.pb.h"

namespace metronome {
namespace {

static_assert(std::endian::native == std::endian::little, "the frame is copied as it lies");

constexpr std::string_view kMagic = "METRCKPT";
constexpr std::size_t kVersionAt = 8, kLengthAt = 12, kDigestAt = 20, kPayloadAt = 52;

template <typename T>
std::vector<T> FromField(const google::protobuf::RepeatedField<T>& field) {
  return {field.begin(), field.end()};
}

void ToPayload(const RunningStatistics& statistics, StatisticsPayload& payload) {
  payload.mutable_mean()->Assign(statistics.mean.begin(), statistics.mean.end());
  payload.mutable_m2()->Assign(statistics.m2.begin(), statistics.m2.end());
  payload.set_count(statistics.count);
}

RunningStatistics FromPayload(const StatisticsPayload& payload) {
  return {FromField(payload.mean()), FromField(payload.m2()), payload.count()};
}

void ToPayload(const TrainState& state, TrainStatePayload& payload) {
  payload.set_version(state.version);
  payload.set_steps(state.steps);
  payload.mutable_parameters()->Assign(state.parameters.begin(), state.parameters.end());
  payload.mutable_adam_m()->Assign(state.adam_m.begin(), state.adam_m.end());
  payload.mutable_adam_v()->Assign(state.adam_v.begin(), state.adam_v.end());
  payload.set_adam_steps(state.adam_steps);
  ToPayload(state.observation, *payload.mutable_observation());
  ToPayload(state.reward_return, *payload.mutable_reward_return());
  payload.mutable_previous_actor()->Assign(state.previous_actor.begin(),
                                           state.previous_actor.end());
  ToPayload(state.previous_observation, *payload.mutable_previous_observation());
  payload.set_canonical_digest(state.canonical_digest);
  payload.set_episodes_used(state.episodes_used);
}

TrainState FromPayload(const TrainStatePayload& payload) {
  TrainState state;
  state.version = payload.version();
  state.steps = payload.steps();
  state.parameters = FromField(payload.parameters());
  state.adam_m = FromField(payload.adam_m());
  state.adam_v = FromField(payload.adam_v());
  state.adam_steps = payload.adam_steps();
  state.observation = FromPayload(payload.observation());
  state.reward_return = FromPayload(payload.reward_return());
  state.previous_actor = FromField(payload.previous_actor());
  state.previous_observation = FromPayload(payload.previous_observation());
  state.canonical_digest = payload.canonical_digest();
  state.episodes_used = payload.episodes_used();
  return state;
}

std::string SerialisePayload(const Checkpoint& checkpoint) {
  CheckpointPayload payload;
  *payload.mutable_config() = checkpoint.config;
  ToPayload(checkpoint.state, *payload.mutable_state());
  payload.set_engine(checkpoint.engine);
  payload.set_build(checkpoint.build);
  payload.set_incarnation(checkpoint.incarnation);
  payload.set_progress_bytes(checkpoint.logs.progress_bytes);
  payload.set_events_bytes(checkpoint.logs.events_bytes);
  payload.set_wall_seconds(checkpoint.logs.wall_seconds);
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

Sha256Digest DigestOf(std::string_view frame, std::string_view payload) {
  std::string covered(frame.substr(0, kDigestAt));
  covered.append(payload);
  return Sha256(covered);
}

/// @return the payload of a file whose every byte is as it was written.
std::string_view CheckFrame(std::string_view bytes, const std::string& name) {
  if (bytes.size() < kPayloadAt || bytes.substr(0, kMagic.size()) != kMagic) {
    throw CheckpointDamaged(name + ": not a Metronome checkpoint (damaged at its start, or " +
                            "something else altogether; " + std::to_string(bytes.size()) +
                            " bytes)");
  }
  const auto length = Get<std::uint64_t>(bytes, kLengthAt);
  const std::string_view payload = bytes.substr(kPayloadAt);
  const Sha256Digest digest = DigestOf(bytes, payload);
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
  return payload;
}

void RequireSize(std::size_t size, std::size_t wanted, const std::string& what,
                 const std::string& name) {
  if (size == wanted) return;
  throw CheckpointError(name + ": another shape: " + what + " has " + std::to_string(size) +
                        " numbers, its configuration asks for " + std::to_string(wanted));
}

void RequireStatistics(const RunningStatistics& statistics, std::size_t dimensions,
                       const std::string& what, const std::string& name) {
  const bool empty = statistics.mean.empty() && statistics.m2.empty() && statistics.count == 0;
  if (empty) return;
  RequireSize(statistics.mean.size(), dimensions, what, name);
  RequireSize(statistics.m2.size(), dimensions, what, name);
}

void RequireConsistent(const Checkpoint& checkpoint, const std::string& name) {
  try {
    Validate(checkpoint.config);
  } catch (const ConfigError& error) {
    throw CheckpointError(name + ": its configuration is not valid: " + error.what());
  }
  const NetworkShape shape = ShapeOf(checkpoint.config);
  const std::size_t count = ParameterCount(shape);
  const TrainState& state = checkpoint.state;
  RequireSize(state.parameters.size(), count, "the network", name);
  RequireSize(state.adam_m.size(), count, "Adam's first moment", name);
  RequireSize(state.adam_v.size(), count, "Adam's second moment", name);
  if (!state.previous_actor.empty()) {
    RequireSize(state.previous_actor.size(), ActorLayout(shape).size, "the previous policy", name);
  }
  RequireStatistics(state.observation, kObservationSize, "the observation statistics", name);
  RequireStatistics(state.previous_observation, kObservationSize,
                    "the previous observation statistics", name);
  RequireStatistics(state.reward_return, 1, "the return statistics", name);
}

std::string ShapeText(const RunConfig& config) {
  const NetworkShape shape = ShapeOf(config);
  std::string text = std::to_string(shape.input()) + " inputs, hidden";
  for (const auto width : shape.hidden) text += " " + std::to_string(width);
  return text + ", " + std::to_string(shape.heads) + " heads of " + std::to_string(shape.action) +
         ", " + std::to_string(shape.critic_heads) + " of the critic";
}

}  // namespace

std::string EncodeCheckpoint(const Checkpoint& checkpoint) {
  const std::string payload = SerialisePayload(checkpoint);
  std::string bytes(kMagic);
  Put(bytes, kCheckpointFormat);
  Put(bytes, static_cast<std::uint64_t>(payload.size()));
  const Sha256Digest digest = DigestOf(bytes, payload);
  bytes.append(reinterpret_cast<const char*>(digest.data()), digest.size());
  return bytes + payload;
}

Checkpoint DecodeCheckpoint(std::string_view bytes, const std::string& name) {
  const std::string_view raw = CheckFrame(bytes, name);
  CheckpointPayload payload;
  if (raw.size() > INT32_MAX || !payload.ParseFromArray(raw.data(), static_cast<int>(raw.size()))) {
    throw CheckpointError(name + ": its payload is not a checkpoint's");
  }
  Checkpoint checkpoint;
  checkpoint.config = payload.config();
  checkpoint.state = FromPayload(payload.state());
  checkpoint.engine = payload.engine();
  checkpoint.build = payload.build();
  checkpoint.incarnation = payload.incarnation();
  checkpoint.logs = {payload.progress_bytes(), payload.events_bytes(), payload.wall_seconds()};
  checkpoint.initial_weights_sha256 = payload.initial_weights_sha256();
  RequireConsistent(checkpoint, name);
  return checkpoint;
}

void RequireShape(const Checkpoint& checkpoint, const RunConfig& config, const std::string& name) {
  if (ShapeOf(checkpoint.config) == ShapeOf(config)) return;
  throw CheckpointError(name + ": another network shape: it holds " + ShapeText(checkpoint.config) +
                        "; asked for is " + ShapeText(config));
}

}  // namespace metronome
