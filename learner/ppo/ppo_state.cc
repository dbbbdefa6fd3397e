#include "learner/ppo/ppo_state.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "common/checkpoint/repeated_field.h"
#include "common/policy/network.h"
#include "common/policy/snapshot.h"
#include "common/policy/task_of.h"
#include "common/process/sha256.h"
#include "learner/algorithm/algorithm_factory.h"
#include "learner/ppo/ppo_state.pb.h"

namespace metronome::ppo {
namespace {

constexpr char kName[] = "ppo";

using Statistics = std::vector<policy::RunningStatistics>;
using StatisticsField = google::protobuf::RepeatedPtrField<PpoStatePayload::Statistics>;

void ToPayload(const Statistics& statistics, StatisticsField& field) {
  for (const policy::RunningStatistics& of_task : statistics) {
    PpoStatePayload::Statistics& payload = *field.Add();
    payload.mutable_mean()->Assign(of_task.mean.begin(), of_task.mean.end());
    payload.mutable_m2()->Assign(of_task.m2.begin(), of_task.m2.end());
    payload.set_count(of_task.count);
  }
}

Statistics FromPayload(const StatisticsField& field) {
  Statistics statistics;
  for (const PpoStatePayload::Statistics& payload : field) {
    statistics.push_back({checkpoint::FromField(payload.mean()),
                          checkpoint::FromField(payload.m2()), payload.count()});
  }
  return statistics;
}

void ToPayload(const Episode& episode, PpoStatePayload::EarlierEpisode& payload) {
  payload.set_number(episode.number);
  payload.set_weights_version(episode.weights_version);
  payload.mutable_observation()->Assign(episode.observation.begin(), episode.observation.end());
  payload.mutable_action()->Assign(episode.action.begin(), episode.action.end());
  payload.mutable_log_prob()->Assign(episode.log_prob.begin(), episode.log_prob.end());
  payload.mutable_reward()->Assign(episode.reward.begin(), episode.reward.end());
  payload.mutable_head()->Assign(episode.head.begin(), episode.head.end());
  payload.mutable_flags()->assign(episode.flags.begin(), episode.flags.end());
}

Episode FromPayload(const PpoStatePayload::EarlierEpisode& payload) {
  Episode episode;
  episode.number = payload.number();
  episode.weights_version = payload.weights_version();
  episode.observation = checkpoint::FromField(payload.observation());
  episode.action = checkpoint::FromField(payload.action());
  episode.log_prob = checkpoint::FromField(payload.log_prob());
  episode.reward = checkpoint::FromField(payload.reward());
  episode.head.assign(payload.head().begin(), payload.head().end());
  episode.flags.assign(payload.flags().begin(), payload.flags().end());
  return episode;
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
  payload.mutable_shared_m()->Assign(state.shared.m.begin(), state.shared.m.end());
  payload.mutable_shared_v()->Assign(state.shared.v.begin(), state.shared.v.end());
  for (const Episode& episode : state.earlier) ToPayload(episode, *payload.add_earlier());
  return payload.SerializeAsString();
}

void RequireSize(std::size_t size, std::size_t wanted, const std::string& what) {
  if (size == wanted) return;
  throw algorithm::UnusableState("its state of ppo has another shape: " + what + " has " +
                                 std::to_string(size) + " numbers, its configuration asks for " +
                                 std::to_string(wanted));
}

void RequireStatistics(const Statistics& statistics, std::size_t tasks, std::size_t dimensions,
                       const std::string& what) {
  if (statistics.size() != tasks) {
    throw algorithm::UnusableState("its state of ppo has another shape: " + what + " are of " +
                                   std::to_string(statistics.size()) +
                                   " tasks, its configuration has " + std::to_string(tasks));
  }
  for (const policy::RunningStatistics& of_task : statistics) {
    const bool empty = of_task.mean.empty() && of_task.m2.empty() && of_task.count == 0;
    if (empty) continue;
    RequireSize(of_task.mean.size(), dimensions, what);
    RequireSize(of_task.m2.size(), dimensions, what);
  }
}

void RequireEpisode(const Episode& episode, const policy::NetworkShape& shape) {
  const std::size_t length = episode.reward.size();
  const std::string what = "episode " + std::to_string(episode.number) + "'s ";
  RequireSize(episode.observation.size(), (length + 1) * std::size_t(shape.observation),
              what + "observation");
  RequireSize(episode.action.size(), length * std::size_t(shape.action), what + "action");
  RequireSize(episode.log_prob.size(), length, what + "log-probability");
  RequireSize(episode.head.size(), length, what + "head");
  RequireSize(episode.flags.size(), length, what + "flags");
  const auto beyond =
      std::find_if(episode.head.begin(), episode.head.end(),
                   [&shape](std::uint16_t head) { return std::int32_t(head) >= shape.heads; });
  if (length > 0 && beyond == episode.head.end()) return;
  throw algorithm::UnusableState("its state of ppo has another shape: episode " +
                                 std::to_string(episode.number) +
                                 " has no steps, or a head that the network has not");
}

void RequireFit(const PpoState& state, const RunConfig& config) {
  const policy::NetworkShape shape = policy::ShapeOf(config);
  const std::size_t count = policy::ParameterCount(shape);
  RequireSize(state.parameters.size(), count, "the network");
  RequireSize(state.adam_m.size(), count, "Adam's first moment");
  RequireSize(state.adam_v.size(), count, "Adam's second moment");
  if (!state.shared.m.empty() || !state.shared.v.empty()) {
    const std::size_t shared = network::SharedHeads(shape).size();
    RequireSize(state.shared.m.size(), shared, "the first moment of what heads share");
    RequireSize(state.shared.v.size(), shared, "the second moment of what heads share");
  }
  if (!state.previous_actor.empty()) {
    RequireSize(state.previous_actor.size(), policy::ActorLayout(shape).size,
                "the previous policy");
  }
  const auto observations = std::size_t(shape.observation);
  const auto tasks = std::size_t(shape.tasks);
  RequireStatistics(state.observation, tasks, observations, "the observation statistics");
  RequireStatistics(state.previous_observation, tasks, observations,
                    "the previous observation statistics");
  RequireStatistics(state.reward_return, tasks, std::size_t(shape.values), "the return statistics");
  for (const Episode& episode : state.earlier) RequireEpisode(episode, shape);
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
  state.shared.m = checkpoint::FromField(payload.shared_m());
  state.shared.v = checkpoint::FromField(payload.shared_v());
  for (const auto& episode : payload.earlier()) state.earlier.push_back(FromPayload(episode));
  // Of files from before overlap.
  if (state.previous_observation.empty())
    state.previous_observation.resize(policy::TaskCount(config));
  RequireFit(state, config);
  return state;
}

}  // namespace metronome::ppo
