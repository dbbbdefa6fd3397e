#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/kernels/matrix.h"
#include "common/policy/packed_network.h"

namespace metronome::network {

/// How the gradients of a minibatch's n samples are summed, the rest of the rule of
/// kernels/product.h: the samples, in their order, are dealt over kGroups groups; of each group
/// every parameter has one chain that starts at zero, and the groups' chains are added in their
/// order. A group's part is a gradient of its own: who computes it, where and how, changes no bit.
struct SampleGroups {
  static constexpr std::size_t kGroups = 32;

  std::size_t samples = 0;

  [[nodiscard]] std::size_t begin(std::size_t group) const { return group * samples / kGroups; }
  [[nodiscard]] std::size_t end(std::size_t group) const { return begin(group + 1); }
  /// Rows of a run that are in the group; it may have none.
  [[nodiscard]] policy::HeadRun PartOf(const policy::HeadRun& run, std::size_t group) const {
    const std::size_t first = std::max(run.begin, begin(group));
    const std::size_t last = std::min(run.end(), end(group));
    return {run.head, first, last > first ? last - first : 0};
  }
};

/// Numbers [first, first + count) of a flat parameter vector.
struct ParameterRange {
  std::size_t first = 0;
  std::size_t count = 0;
};

/// One MLP with k output heads, forward and backward over the samples of a minibatch, which lie in
/// rows, sorted by head. Work comes in pieces, for threads to share: rows for the passes, parts of
/// the parameters for gradients and packing. Neither cut changes a bit.
class Mlp {
 public:
  /// @param rows  samples of a minibatch, at most.
  /// @param inputs_with_gradient  of the last so many inputs Backward leaves the gradient too; that
  ///                              takes a hidden layer.
  /// @param backward  false: a network without Backward, which is packed the faster.
  Mlp(policy::MlpLayout layout, std::size_t rows, std::size_t inputs_with_gradient = 0,
      bool backward = true);

  [[nodiscard]] const policy::MlpLayout& layout() const { return layout_; }
  /// [rows, head_outputs], each row by its own head.
  [[nodiscard]] const kernels::Matrix& output() const { return rows_.output; }
  kernels::Matrix& d_output() { return d_output_; }  // of the loss by output(), to be written
  [[nodiscard]] const kernels::Matrix& d_input() const { return d_input_; }  // by the last inputs

  /// Parts of the weights and biases. @param parameters  here and below the network's block of the
  /// flat vector, layout().size floats.
  [[nodiscard]] std::size_t weight_parts() const { return weight_parts_.size(); }
  /// The parameters of a part, which no other part has.
  [[nodiscard]] std::vector<ParameterRange> RangesOf(std::size_t weight_part) const;
  /// Takes a part's parameters; a pass needs all parts packed.
  void Pack(std::size_t weight_part, const float* parameters);
  /// Takes the parameters of all heads.
  void PackHeads(const float* parameters);

  /// output() of rows [first, first + count) from their input [rows, inputs]. @param runs  their
  /// heads; begin counts from row 0. Thread-safe where rows differ, as Backward is.
  void Forward(const kernels::Matrix& input, std::size_t first, std::size_t count,
               const std::vector<policy::HeadRun>& runs);
  /// What gradients of these rows need from their d_output.
  void Backward(std::size_t first, std::size_t count, const std::vector<policy::HeadRun>& runs);

  /// Parts of the gradient of sum(d_output .* output) over all rows after their Backward.
  [[nodiscard]] std::size_t gradient_parts() const { return gradient_parts_.size(); }
  /// Writes one part. @param input, runs  of all samples; one run a head at most.
  /// @param gradient  layout().size floats, of which the part's are written; log-std is left alone.
  /// @return the sum of the part's squares, in a fixed order.
  double Gradient(std::size_t gradient_part, const kernels::Matrix& input,
                  const SampleGroups& groups, const std::vector<policy::HeadRun>& runs,
                  float* gradient) const;

 private:
  /// Some outputs of a hidden layer or of a head, and some inputs.
  struct Part {
    policy::LayerSlice slice;  // all of the layer, or of the head
    std::size_t layer = 0;     // hidden.size(): a head
    std::size_t head = 0;
    std::size_t first_output = 0;
    std::size_t outputs = 0;
    std::size_t first_input = 0;
    std::size_t inputs = 0;
  };

  void AddParts(const policy::LayerSlice& slice, std::size_t layer, std::size_t head);
  [[nodiscard]] bool IsHead(const Part& part) const { return part.layer == layout_.hidden.size(); }

  policy::MlpLayout layout_;
  policy::PackedNetwork forward_;
  // Weights as they are, in panels of 16 inputs, [outputs, 16] each: of the hidden layers (of the
  // first one those of the last inputs_with_gradient), and of the heads where there is a hidden
  // layer. Without numbers where there is no Backward.
  std::vector<kernels::Matrix> backward_hidden_;
  std::vector<kernels::Matrix> backward_heads_;
  policy::Activations rows_;
  std::vector<kernels::Matrix> d_hidden_;  // by the layer's sums
  kernels::Matrix d_output_;
  kernels::Matrix d_input_;
  std::vector<Part> weight_parts_;
  std::vector<Part> gradient_parts_;
};

}  // namespace metronome::network
