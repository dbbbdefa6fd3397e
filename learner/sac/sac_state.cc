#include "learner/sac/sac_state.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "common/checkpoint/repeated_field.h"
#include "common/checkpoint/statistics_field.h"
#include "common/numbers/elementary.h"
#include "common/policy/snapshot.h"
#include "common/policy/task_of.h"
#include "common/process/sha256.h"
#include "learner/algorithm/algorithm_factory.h"
#include "learner/algorithm/state_fit.h"
#include "learner/network/initialise.h"
#include "learner/network/shared_heads.h"
#include "learner/sac/sac_networks.h"
#include "learner/sac/sac_state.pb.h"

namespace metronome::sac {
namespace {

constexpr char kName[] = "sac";

using Floats = std::vector<float>;
using Moments = OptimiserState::Moments;

Moments ZeroMoments(std::size_t size) { return {Floats(size, 0.0F), Floats(size, 0.0F)}; }

OptimiserState::Shared ZeroShared(std::size_t size) {
  return {Floats(size, 0.0F), Floats(size, 0.0F)};
}

void ToPayload(const OptimiserState::Shared& shared, SacStatePayload::Weights& weights) {
  weights.mutable_shared_m()->Assign(shared.m.begin(), shared.m.end());
  weights.mutable_shared_v()->Assign(shared.v.begin(), shared.v.end());
}

OptimiserState::Shared SharedOf(const SacStatePayload::Weights& weights) {
  return {checkpoint::FromField(weights.shared_m()), checkpoint::FromField(weights.shared_v())};
}

void ToPayload(const Floats& parameters, const Moments& moments,
               SacStatePayload::Weights& weights) {
  weights.mutable_parameters()->Assign(parameters.begin(), parameters.end());
  weights.mutable_adam_m()->Assign(moments.m.begin(), moments.m.end());
  weights.mutable_adam_v()->Assign(moments.v.begin(), moments.v.end());
}

void FromPayload(const SacStatePayload::Weights& weights, Floats& parameters, Moments& moments) {
  parameters = checkpoint::FromField(weights.parameters());
  moments = {checkpoint::FromField(weights.adam_m()), checkpoint::FromField(weights.adam_v())};
}

std::string BytesOf(const SacState& state) {
  const OptimiserState& optimiser = state.optimiser;
  SacStatePayload payload;
  ToPayload(optimiser.actor, optimiser.of_actor, *payload.mutable_actor());
  ToPayload(optimiser.critics, optimiser.of_critics, *payload.mutable_critics());
  ToPayload(optimiser.log_temperature, optimiser.of_log_temperature,
            *payload.mutable_log_temperature());
  ToPayload(optimiser.of_actor_heads, *payload.mutable_actor());
  ToPayload(optimiser.of_critic_heads, *payload.mutable_critics());
  payload.mutable_targets()->Assign(optimiser.targets.begin(), optimiser.targets.end());
  payload.set_gradient_steps(optimiser.gradient_steps);
  checkpoint::ToField(state.observation, *payload.mutable_observation());
  payload.mutable_previous_actor()->Assign(state.previous_actor.begin(),
                                           state.previous_actor.end());
  checkpoint::ToField(state.previous_observation, *payload.mutable_previous_observation());
  return payload.SerializeAsString();
}

void RequireSizes(const algorithm::StateFit& fit, const Floats& parameters, const Moments& moments,
                  std::size_t wanted, const std::string& what) {
  fit.Size(parameters.size(), wanted, what);
  fit.Size(moments.m.size(), wanted, "Adam's first moment of " + what);
  fit.Size(moments.v.size(), wanted, "Adam's second moment of " + what);
}

void RequireFit(const SacState& state, const RunConfig& config) {
  const algorithm::StateFit fit(kName);
  const SacNetworks networks(config);
  const OptimiserState& optimiser = state.optimiser;
  const std::size_t critics = kCritics * networks.critic.size;
  RequireSizes(fit, optimiser.actor, optimiser.of_actor, networks.actor.size, "the policy");
  RequireSizes(fit, optimiser.critics, optimiser.of_critics, critics, "the critics");
  fit.Size(optimiser.targets.size(), critics, "the target critics");
  RequireSizes(fit, optimiser.log_temperature, optimiser.of_log_temperature,
               std::size_t(networks.shape.heads), "the temperatures");
  const bool shared = config.sac().shared_heads();
  const std::size_t of_actor = shared ? network::SharedHeads({networks.actor}).size() : 0;
  const std::size_t of_critics =
      shared ? network::SharedHeads({networks.critic, networks.critic}).size() : 0;
  fit.Size(optimiser.of_actor_heads.m.size(), of_actor, "what heads of the policy share");
  fit.Size(optimiser.of_actor_heads.v.size(), of_actor, "what heads of the policy share");
  fit.Size(optimiser.of_critic_heads.m.size(), of_critics, "what heads of the critics share");
  fit.Size(optimiser.of_critic_heads.v.size(), of_critics, "what heads of the critics share");
  if (!state.previous_actor.empty()) {
    fit.Size(state.previous_actor.size(), networks.actor.size, "the previous policy");
  }
  const auto observations = std::size_t(networks.shape.observation);
  const auto tasks = std::size_t(networks.shape.tasks);
  fit.Statistics(state.observation, tasks, observations, "the observation statistics");
  fit.Statistics(state.previous_observation, tasks, observations,
                 "the previous observation statistics");
}

Floats AllWeights(const OptimiserState& optimiser) {
  Floats all = optimiser.actor;
  for (const Floats* more : {&optimiser.critics, &optimiser.targets, &optimiser.log_temperature}) {
    all.insert(all.end(), more->begin(), more->end());
  }
  return all;
}

}  // namespace

SacState InitialSacState(const RunConfig& config) {
  const SacNetworks networks(config);
  SacState state;
  OptimiserState& optimiser = state.optimiser;
  network::Initialiser initialiser(config.seed());
  optimiser.actor = initialiser.Network(networks.actor, 0.01);
  for (std::size_t i = 0; i < kCritics; ++i) {
    const Floats critic = initialiser.Network(networks.critic, 0);
    optimiser.critics.insert(optimiser.critics.end(), critic.begin(), critic.end());
  }
  if (config.sac().shared_heads()) {
    const network::SharedHeads of_actor({networks.actor});
    const network::SharedHeads of_critics({networks.critic, networks.critic});
    of_actor.MakeEqual(optimiser.actor);
    of_critics.MakeEqual(optimiser.critics);
    optimiser.of_actor_heads = ZeroShared(of_actor.size());
    optimiser.of_critic_heads = ZeroShared(of_critics.size());
  }
  optimiser.targets = optimiser.critics;
  optimiser.log_temperature.assign(std::size_t(networks.shape.heads),
                                   float(numbers::Log(config.sac().initial_temperature())));
  optimiser.of_actor = ZeroMoments(optimiser.actor.size());
  optimiser.of_critics = ZeroMoments(optimiser.critics.size());
  optimiser.of_log_temperature = ZeroMoments(optimiser.log_temperature.size());
  state.observation.resize(policy::TaskCount(config));
  state.previous_observation.resize(policy::TaskCount(config));
  return state;
}

PolicySnapshot SnapshotOf(const SacState& state, const RunConfig& config) {
  return policy::MakeSnapshot(state.version, state.optimiser.actor.data(), state.observation,
                              config);
}

PolicySnapshot PreviousSnapshotOf(const SacState& state, const RunConfig& config) {
  if (state.version == 0 || state.previous_actor.size() != state.optimiser.actor.size()) {
    throw std::logic_error("version " + std::to_string(state.version) +
                           " has no previous snapshot");
  }
  return policy::MakeSnapshot(state.version - 1, state.previous_actor.data(),
                              state.previous_observation, config);
}

checkpoint::TrainState EncodeSacState(const SacState& state, const RunConfig& config) {
  checkpoint::TrainState encoded;
  static_cast<checkpoint::RunCounters&>(encoded) = state;
  encoded.policy = SnapshotOf(state, config);
  const Floats weights = AllWeights(state.optimiser);
  encoded.weights = {weights.size(), process::WeightsSha256(weights)};
  encoded.algorithm = {kName, kSacStateFormat, BytesOf(state)};
  return encoded;
}

SacState DecodeSacState(const checkpoint::TrainState& encoded, const RunConfig& config) {
  algorithm::RequireFormat(encoded.algorithm, kName, kSacStateFormat);
  SacStatePayload payload;
  if (!payload.ParseFromString(encoded.algorithm.bytes)) {
    throw algorithm::UnusableState("its state of sac is not one");
  }
  SacState state;
  static_cast<checkpoint::RunCounters&>(state) = encoded;
  OptimiserState& optimiser = state.optimiser;
  FromPayload(payload.actor(), optimiser.actor, optimiser.of_actor);
  FromPayload(payload.critics(), optimiser.critics, optimiser.of_critics);
  FromPayload(payload.log_temperature(), optimiser.log_temperature, optimiser.of_log_temperature);
  optimiser.of_actor_heads = SharedOf(payload.actor());
  optimiser.of_critic_heads = SharedOf(payload.critics());
  optimiser.targets = checkpoint::FromField(payload.targets());
  optimiser.gradient_steps = payload.gradient_steps();
  state.observation = checkpoint::StatisticsOf(payload.observation());
  state.previous_actor = checkpoint::FromField(payload.previous_actor());
  state.previous_observation = checkpoint::StatisticsOf(payload.previous_observation());
  RequireFit(state, config);
  return state;
}

}  // namespace metronome::sac
