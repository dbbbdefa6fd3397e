#include "learner/ppo/ppo_state.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "common/checkpoint/repeated_field.h"
#include "common/checkpoint/statistics_field.h"
#include "common/policy/network.h"
#include "common/policy/snapshot.h"
#include "common/policy/task_of.h"
#include "common/process/sha256.h"
#include "learner/algorithm/algorithm_factory.h"
#include "learner/algorithm/state_fit.h"
#include "learner/ppo/ppo_state.pb.h"

namespace metronome::ppo {
namespace {

constexpr char kName[] = "ppo";

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
  checkpoint::ToField(state.observation, *payload.mutable_observation());
  checkpoint::ToField(state.reward_return, *payload.mutable_reward_return());
  payload.mutable_previous_actor()->Assign(state.previous_actor.begin(),
                                           state.previous_actor.end());
  checkpoint::ToField(state.previous_observation, *payload.mutable_previous_observation());
  payload.mutable_shared_m()->Assign(state.shared.m.begin(), state.shared.m.end());
  payload.mutable_shared_v()->Assign(state.shared.v.begin(), state.shared.v.end());
  for (const Episode& episode : state.earlier) ToPayload(episode, *payload.add_earlier());
  return payload.SerializeAsString();
}

void RequireEpisode(const algorithm::StateFit& fit, const Episode& episode,
                    const policy::NetworkShape& shape) {
  const std::size_t length = episode.reward.size();
  const std::string what = "episode " + std::to_string(episode.number) + "'s ";
  fit.Size(episode.observation.size(), (length + 1) * std::size_t(shape.observation),
           what + "observation");
  fit.Size(episode.action.size(), length * std::size_t(shape.action), what + "action");
  fit.Size(episode.log_prob.size(), length, what + "log-probability");
  fit.Size(episode.head.size(), length, what + "head");
  fit.Size(episode.flags.size(), length, what + "flags");
  const auto beyond =
      std::find_if(episode.head.begin(), episode.head.end(),
                   [&shape](std::uint16_t head) { return std::int32_t(head) >= shape.heads; });
  if (length > 0 && beyond == episode.head.end()) return;
  fit.Refuse("episode " + std::to_string(episode.number) +
             " has no steps, or a head that the network has not");
}

void RequireFit(const PpoState& state, const RunConfig& config) {
  const algorithm::StateFit fit(kName);
  const policy::NetworkShape shape = policy::ShapeOf(config);
  const std::size_t count = policy::ParameterCount(shape);
  fit.Size(state.parameters.size(), count, "the network");
  fit.Size(state.adam_m.size(), count, "Adam's first moment");
  fit.Size(state.adam_v.size(), count, "Adam's second moment");
  if (!state.shared.m.empty() || !state.shared.v.empty()) {
    const std::size_t shared = network::SharedHeads(shape).size();
    fit.Size(state.shared.m.size(), shared, "the first moment of what heads share");
    fit.Size(state.shared.v.size(), shared, "the second moment of what heads share");
  }
  if (!state.previous_actor.empty()) {
    fit.Size(state.previous_actor.size(), policy::ActorLayout(shape).size, "the previous policy");
  }
  const auto observations = std::size_t(shape.observation);
  const auto tasks = std::size_t(shape.tasks);
  fit.Statistics(state.observation, tasks, observations, "the observation statistics");
  fit.Statistics(state.previous_observation, tasks, observations,
                 "the previous observation statistics");
  fit.Statistics(state.reward_return, tasks, std::size_t(shape.values), "the return statistics");
  for (const Episode& episode : state.earlier) RequireEpisode(fit, episode, shape);
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
  state.observation = checkpoint::StatisticsOf(payload.observation());
  state.reward_return = checkpoint::StatisticsOf(payload.reward_return());
  state.previous_actor = checkpoint::FromField(payload.previous_actor());
  state.previous_observation = checkpoint::StatisticsOf(payload.previous_observation());
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
