#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "common/messages/episode.h"
#include "common/messages/messages.h"
#include "common/policy/head_schedule.h"
#include "common/policy/network.h"
#include "common/schema/config.pb.h"

namespace metronome::policy {

/// The policy of one snapshot, one state at a time: what actors act with and what the learner
/// recomputes, to the last bit, when it checks them. Diagonal Gaussian; the episode's schedule
/// picks the head, which makes one Policy serve any number of episodes, in any order.
///
/// Bit-equality: every sum runs over its inputs in order, in fused multiply-adds where
/// METRONOME_MARCH has them (vectors run along the outputs), so neither vector width nor alignment
/// enters. Not thread-safe: it keeps scratch space; make one per thread.
class Policy {
 public:
  /// Room for the largest action: the first action_size numbers count.
  using Action = std::array<float, kMaxActionSize>;
  struct Decision {
    Action mean{};
    Action action{};     // mean + std * noise, not clipped
    float log_prob = 0;  // nats, of `action`
    std::int32_t head = 0;
  };

  /// @param config  resolved. @throws std::invalid_argument if the snapshot has another shape.
  Policy(const RunConfig& config, const PolicySnapshot& snapshot);

  [[nodiscard]] std::uint64_t version() const { return version_; }  // of the snapshot

  /// Mean action of the head that owns step t. Here and below:
  /// @param schedule     of the episode. @throws std::invalid_argument if it has another k.
  /// @param observation  [O], as published, of the schedule's task. @param t  in [0, T).
  Action Mean(const HeadSchedule& schedule, const float* observation, std::int32_t t);

  /// Mean of kStates consecutive steps at once, to the bit as one by one and in half the time.
  /// @param observations  [kStates, O]. @param t  of the first, in [0, T - kStates].
  static constexpr int kStates = 4;
  std::array<Action, kStates> Means(const HeadSchedule& schedule, const float* observations,
                                    std::int32_t t);

  /// Samples the action of step t with the standard normal numbers of `noise`.
  Decision Act(const HeadSchedule& schedule, const float* observation, std::int32_t t,
               const Action& noise);
  /// The same where the mean of step t is known.
  [[nodiscard]] Decision ActAround(const HeadSchedule& schedule, const Action& mean, std::int32_t t,
                                   const Action& noise) const;

 private:
  /// Weight transposed to [inputs, padded outputs] row-major, so that vectors run along outputs;
  /// padding is zeros.
  struct Layer {
    std::int32_t inputs = 0;
    Eigen::Index padded = 0;  // outputs, rounded up to whole vectors
    Eigen::VectorXf weight_t;
    Eigen::VectorXf bias;

    /// outputs = weight * inputs + bias, for States columns.
    template <int States>
    void Apply(const float* input, Eigen::Index input_stride, float* output,
               Eigen::Index output_stride) const;
    template <int States, int Vectors>
    void ApplyTo(Eigen::Index first, const float* input, Eigen::Index input_stride, float* output,
                 Eigen::Index output_stride) const;
  };

  static Layer Transpose(const float* parameters, const LayerSlice& slice, std::int32_t first_row,
                         std::int32_t rows);
  template <int States>
  void MeansOf(const HeadSchedule& schedule, const float* observations, std::int32_t t,
               Action* means);
  void RequireFit(const HeadSchedule& schedule) const;

  std::uint64_t version_;
  NetworkShape shape_;
  float clip_;
  std::vector<float> observation_mean_;
  std::vector<float> observation_inv_std_;
  std::vector<Layer> hidden_;
  std::vector<Layer> heads_;                  // [k]
  std::vector<Action> log_std_;               // [k]
  std::vector<Action> std_;                   // [k]
  Eigen::MatrixXf input_;                     // [inputs, kStates]
  std::vector<Eigen::MatrixXf> activations_;  // one per hidden layer, [padded outputs, kStates]
  Eigen::VectorXf head_output_;               // padded
};

}  // namespace metronome::policy
