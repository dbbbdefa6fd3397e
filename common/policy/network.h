#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/schema/config.pb.h"

namespace metronome::policy {

/// Shape of actor and critic: separate tanh MLPs of equal widths.
struct NetworkShape {
  std::int32_t observation = 1;
  std::int32_t tasks = 1;     // each with observation statistics of its own
  bool task_onehot = false;   // a number a task is appended, after normalisation
  bool time_feature = false;  // single-time: 2t/T-1 is appended, after normalisation and task
  bool critic_time = false;   // the same, for the critic alone
  std::vector<std::int32_t> hidden = {128, 128};
  std::int32_t heads = 10;         // in all: by time, by task or by both
  std::int32_t critic_heads = 10;  // one a head, or 1 for all (policy.critic_heads)
  std::int32_t action = 1;
  std::int32_t values = 1;  // of a state: the parts of the reward that are valued apart
  /// SAC: a head has a mean and a log-std for each number of the action, of the state, and the
  /// action is the hyperbolic tangent of what is drawn. Else the log-stds are parameters of the
  /// head.
  bool squashed = false;

  [[nodiscard]] std::int32_t input() const {
    return observation + (task_onehot ? tasks : 0) + (time_feature ? 1 : 0);
  }
  /// The critic's begins with the policy's.
  [[nodiscard]] std::int32_t critic_input() const { return input() + (critic_time ? 1 : 0); }
  /// Numbers of the observation statistics: [tasks, observation].
  [[nodiscard]] std::size_t statistics() const {
    return std::size_t(tasks) * std::size_t(observation);
  }
  /// The critic's head that values the states of the policy's `head`.
  [[nodiscard]] std::int32_t value_head(std::int32_t head) const {
    return critic_heads == 1 ? 0 : head;
  }
  bool operator==(const NetworkShape&) const = default;
};

/// One dense layer inside a flat parameter vector: weight [outputs, inputs] row-major, then bias
/// [outputs].
struct LayerSlice {
  std::size_t weight = 0;  // offset of the weight's first element
  std::size_t bias = 0;    // offset of the bias's first element
  std::int32_t inputs = 0;
  std::int32_t outputs = 0;
};

/// Where everything lies in the flat float32 parameter vector of one MLP with k output heads:
/// hidden layers in order; then the heads as one layer of k * head_outputs rows, head j owning
/// rows [j * head_outputs, (j + 1) * head_outputs); then (actor only) log-std [k, action].
struct MlpLayout {
  std::vector<LayerSlice> hidden;
  LayerSlice head;
  std::int32_t heads = 0;         // k; of the critic 1 where it is shared
  std::int32_t head_outputs = 0;  // action means (actor; squashed: and log-stds) or values (critic)
  std::size_t log_std = 0;        // actor only, unless squashed; else the size
  std::size_t size = 0;           // floats in all
  bool normalised = false;        // each hidden layer's sums by their root mean square, before tanh
};

/// @throws std::invalid_argument for a width below 1.
MlpLayout LayoutOf(std::int32_t inputs, const std::vector<std::int32_t>& hidden, std::int32_t heads,
                   std::int32_t head_outputs);

MlpLayout ActorLayout(const NetworkShape& shape);
MlpLayout CriticLayout(const NetworkShape& shape);

/// Parameters of both networks: the actor's, then the critic's.
std::size_t ParameterCount(const NetworkShape& shape);

/// The shape that a resolved configuration (common/config/config.h) with its environment's
/// specification asks for.
NetworkShape ShapeOf(const RunConfig& config);

}  // namespace metronome::policy
