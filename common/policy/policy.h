#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/messages/episode.h"
#include "common/messages/messages.h"
#include "common/policy/head_schedule.h"
#include "common/policy/network.h"
#include "common/policy/packed_network.h"
#include "common/schema/config.pb.h"

namespace metronome::policy {

/// The policy of one snapshot, one state or a few at a time: what actors act with and what the
/// learner recomputes, to the last bit, when it checks them. Diagonal Gaussian, squashed or not
/// (NetworkShape); the episode's schedule picks the head, which makes one Policy serve any number
/// of episodes, in any order. Not thread-safe: it keeps scratch space; make one per thread.
class Policy {
 public:
  /// Room for the largest action: the first action_size numbers count.
  using Action = std::array<float, kMaxActionSize>;
  /// Of what is drawn, before any squashing.
  struct Gaussian {
    Action mean{};
    Action log_std{};
  };
  struct Decision {
    Action mean{};       // the Gaussian's
    Action action{};     // mean + std * noise, not clipped; squashed: its hyperbolic tangent
    float log_prob = 0;  // nats, of `action`
    std::int32_t head = 0;
  };

  /// @param config  resolved. @throws std::invalid_argument if the snapshot has another shape.
  Policy(const RunConfig& config, const PolicySnapshot& snapshot);

  [[nodiscard]] std::uint64_t version() const { return version_; }  // of the snapshot

  /// The action of the head that owns step t without noise: the mean, squashed if the policy is.
  /// Here and below:
  /// @param schedule     of the episode. @throws std::invalid_argument if it has another k.
  /// @param observation  [O], as published, of the schedule's task. @param t  in [0, T).
  Action Mean(const HeadSchedule& schedule, const float* observation, std::int32_t t);

  /// Those of consecutive steps at once, to the bit as one by one and several times faster.
  /// @param observations  [gaussians.size(), O]. @param t  of the first. @param gaussians  written;
  ///                      at most kMostStates.
  static constexpr std::size_t kMostStates = PackedNetwork::kRows;
  void Gaussians(const HeadSchedule& schedule, const float* observations, std::int32_t t,
                 std::span<Gaussian> gaussians);

  /// Samples the action of step t with the standard normal numbers of `noise`.
  Decision Act(const HeadSchedule& schedule, const float* observation, std::int32_t t,
               const Action& noise);
  /// The same where the Gaussian of step t is known.
  [[nodiscard]] Decision ActAround(const HeadSchedule& schedule, const Gaussian& gaussian,
                                   std::int32_t t, const Action& noise) const;
  /// An action that no state decides. @param uniform  the action, from -1 to 1.
  [[nodiscard]] Decision ActUniformly(const HeadSchedule& schedule, std::int32_t t,
                                      const Action& uniform) const;

 private:
  void RequireFit(const HeadSchedule& schedule) const;

  std::uint64_t version_;
  NetworkShape shape_;
  float clip_;
  std::vector<float> observation_mean_;
  std::vector<float> observation_inv_std_;
  PackedNetwork network_;
  kernels::Matrix input_;  // [kMostStates, inputs]
  Activations rows_;
  std::vector<HeadRun> runs_;
  // [k] each; squashed: empty
  std::vector<Action> log_std_;
  std::vector<Action> std_;
  std::vector<Action> inv_std_;
};

}  // namespace metronome::policy
