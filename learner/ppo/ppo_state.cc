#include "learner/ppo/ppo_state.h"

#include <stdexcept>
#include <string>

#include "common/checkpoint/repeated_field.h"
#include "common/policy/network.h"
#include "common/policy/snapshot.h"
#include "common/process/sha256.h"
#include "learner/algorithm/algorithm_factory.h"
#include "learner/ppo/ppo_state.pb.h"

namespace metronome::ppo {
namespace {

constexpr char kName[] = "ppo";

void ToPayload(const policy::RunningStatistics& statistics, PpoStatePayload::Statistics& payload) {
  payload.mutable_mean()->Assign(statistics.mean.begin(), statistics.mean.end());
  payload.mutable_m2()->Assign(statistics.m2.begin(), statistics.m2.end());
  payload.set_count(statistics.count);
}

policy::RunningStatistics FromPayload(const PpoStatePayload::Statistics& payload) {
  return {checkpoint::FromField(payload.mean()), checkpoint::FromField(payload.m2()),
          payload.count()};
}

std::string BytesOf(const PpoState& state) {
  PpoStatePayload payload;
  payload.mutable_parameters()->Assign(state.parameters.begin(), state.parameters.end());
  payload.mutable_adam_m()->Assign(state.adam_m.begin(), state.adam_m.end());
  payload.mutable_adam_v()->Assign(state.adam_v.begin(), state.adam_v.end());
  payload.set_adam_steps(state.adam_steps);
  ToPayload(state.observation, *payload.mutable_observation());
  ToPayload(state.reward_return, *payload.mutable_reward_return());
  payload.mutable_previous_actor()->Assign(state.previous_actor.begin(),
                                           state.previous_actor.end());
  ToPayload(state.previous_observation, *payload.mutable_previous_observation());
  return payload.SerializeAsString();
}

void RequireSize(std::size_t size, std::size_t wanted, const std::string& what) {
  if (size == wanted) return;
  throw algorithm::UnusableState("its state of ppo has another shape: " + what + " has " +
                                 std::to_string(size) + " numbers, its configuration asks for " +
                                 std::to_string(wanted));
}

void RequireStatistics(const policy::RunningStatistics& statistics, std::size_t dimensions,
                       const std::string& what) {
  const bool empty = statistics.mean.empty() && statistics.m2.empty() && statistics.count == 0;
  if (empty) return;
  RequireSize(statistics.mean.size(), dimensions, what);
  RequireSize(statistics.m2.size(), dimensions, what);
}

void RequireFit(const PpoState& state, const RunConfig& config) {
  const policy::NetworkShape shape = policy::ShapeOf(config);
  const std::size_t count = policy::ParameterCount(shape);
  RequireSize(state.parameters.size(), count, "the network");
  RequireSize(state.adam_m.size(), count, "Adam's first moment");
  RequireSize(state.adam_v.size(), count, "Adam's second moment");
  if (!state.previous_actor.empty()) {
    RequireSize(state.previous_actor.size(), policy::ActorLayout(shape).size,
                "the previous policy");
  }
  const auto observations = std::size_t(shape.observation);
  RequireStatistics(state.observation, observations, "the observation statistics");
  RequireStatistics(state.previous_observation, observations,
                    "the previous observation statistics");
  RequireStatistics(state.reward_return, 1, "the return statistics");
}

}  // namespace

PolicySnapshot SnapshotOf(const PpoState& state, const RunConfig& config) {
  return policy::MakeSnapshot(state.version, state.parameters.data(), state.observation, config);
}

PolicySnapshot PreviousSnapshotOf(const PpoState& state, const RunConfig& config) {
  if (state.version == 0 ||
      state.previous_actor.size() != policy::ActorLayout(policy::ShapeOf(config)).size) {
    throw std::logic_error("version " + std::to_string(state.version) +
                           " has no previous snapshot");
  }
  return policy::MakeSnapshot(state.version - 1, state.previous_actor.data(),
                              state.previous_observation, config);
}

checkpoint::TrainState EncodePpoState(const PpoState& state, const RunConfig& config) {
  checkpoint::TrainState encoded;
  static_cast<checkpoint::RunCounters&>(encoded) = state;
  encoded.policy = SnapshotOf(state, config);
  encoded.weights = {state.parameters.size(), process::WeightsSha256(state.parameters)};
  encoded.algorithm = {kName, kPpoStateFormat, BytesOf(state)};
  return encoded;
}

PpoState DecodePpoState(const checkpoint::TrainState& encoded, const RunConfig& config) {
  algorithm::RequireFormat(encoded.algorithm, kName, kPpoStateFormat);
  PpoStatePayload payload;
  if (!payload.ParseFromString(encoded.algorithm.bytes)) {
    throw algorithm::UnusableState("its state of ppo is not one");
  }
  PpoState state;
  static_cast<checkpoint::RunCounters&>(state) = encoded;
  state.parameters = checkpoint::FromField(payload.parameters());
  state.adam_m = checkpoint::FromField(payload.adam_m());
  state.adam_v = checkpoint::FromField(payload.adam_v());
  state.adam_steps = payload.adam_steps();
  state.observation = FromPayload(payload.observation());
  state.reward_return = FromPayload(payload.reward_return());
  state.previous_actor = checkpoint::FromField(payload.previous_actor());
  state.previous_observation = FromPayload(payload.previous_observation());
  RequireFit(state, config);
  return state;
}

}  // namespace metronome::ppo
