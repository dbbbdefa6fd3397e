#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/policy/network.h"

namespace metronome::ppo {

/// Columns [begin, begin + count) of a shard that belong to one head.
struct HeadRun {
  std::int32_t head = 0;
  std::int32_t begin = 0;
  std::int32_t count = 0;
};

/// The same columns by the critic's heads: one run where it has one head.
std::vector<HeadRun> ValueRuns(const std::vector<HeadRun>& runs, const policy::NetworkShape& shape);

/// Forward and backward pass of one MLP with k output heads over n samples, which lie in columns.
/// Keeps the activations between the two passes. Not thread-safe.
class Mlp {
 public:
  explicit Mlp(policy::MlpLayout layout);

  /// @param parameters  the network's block of the flat vector, layout().size floats.
  /// @param input       [inputs, n].
  /// @param runs        the heads of the columns: contiguous, covering all n. For Backward, a head
  ///                    has one run at most.
  /// @return outputs [head_outputs, n], each column by its own head; valid until the next call.
  const Eigen::MatrixXf& Forward(const float* parameters, const Eigen::MatrixXf& input,
                                 const std::vector<HeadRun>& runs);

  /// Adds the gradient of sum(d_output .* output) of the last Forward by the parameters.
  /// @param d_output  [head_outputs, n].
  /// @param gradient  layout().size floats, added to (log-std is left alone).
  void Backward(const float* parameters, const Eigen::MatrixXf& input,
                const std::vector<HeadRun>& runs, const Eigen::MatrixXf& d_output, float* gradient);

  [[nodiscard]] const policy::MlpLayout& layout() const { return layout_; }

 private:
  policy::MlpLayout layout_;
  std::vector<Eigen::MatrixXf> activation_;    // per hidden layer [width, n]
  std::vector<Eigen::MatrixXf> d_activation_;  // same shapes
  Eigen::MatrixXf output_;
};

}  // namespace metronome::ppo
