#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/kernels/matrix.h"
#include "common/policy/network.h"

namespace metronome::policy {

/// A dense layer as products read it (common/kernels/product.h): the weight transposed, in panels
/// of 16 outputs, [inputs, 16] each, padded with zeros.
class PackedLayer {
 public:
  PackedLayer(std::int32_t inputs, std::int32_t outputs);

  /// Takes the weight [outputs, inputs], row-major, and the bias [outputs].
  void Pack(const float* weight, const float* bias);
  /// Takes the outputs of one panel, from the same arrays. Panels may be packed side by side.
  void PackPanel(std::size_t panel, const float* weight, const float* bias);

  /// output = bias + weight * input of `rows` rows, by the rule of kernels/product.h.
  void Forward(const float* input, std::size_t input_row, std::size_t rows, float* output,
               std::size_t output_row) const;

 private:
  std::size_t inputs_;
  std::size_t outputs_;
  kernels::Matrix panels_;  // [panels, inputs * 16]
  kernels::Matrix bias_;    // [1, outputs]
};

/// Rows [begin, begin + count) of a block that belong to one output head.
struct HeadRun {
  std::int32_t head = 0;
  std::size_t begin = 0;
  std::size_t count = 0;

  [[nodiscard]] std::size_t end() const { return begin + count; }
};

/// Adds row `row`, which comes after those of the runs.
void AddRow(std::int32_t head, std::size_t row, std::vector<HeadRun>& runs);

/// The same rows by the critic's heads: one run where it has one head.
std::vector<HeadRun> ValueRuns(const std::vector<HeadRun>& runs, const NetworkShape& shape);

/// What a forward pass over some samples, a row each, leaves.
struct Activations {
  /// @param rows  at most.
  Activations(const MlpLayout& layout, std::size_t rows);

  std::vector<kernels::Matrix> hidden;  // of each layer, after tanh [rows, width]
  // Where the layout is normalised, of each hidden layer: what enters tanh [rows, width], and the
  // factor that the sums got [rows].
  std::vector<kernels::Matrix> normalised;
  std::vector<std::vector<float>> inv_rms;
  kernels::Matrix output;  // [rows, head_outputs], each row by its own head
};

/// An MLP with k output heads, packed. One rule gives the bits of the actor's policy, the learner's
/// check and its update.
class PackedNetwork {
 public:
  explicit PackedNetwork(const MlpLayout& layout);
  /// @param parameters  the network's block of the flat vector, layout.size floats.
  PackedNetwork(const MlpLayout& layout, const float* parameters);

  /// Fills hidden and output of rows [first, first + count) from their input [rows, inputs].
  /// Thread-safe where rows differ; a few dozen rows at once keep what is read and written in the
  /// first caches.
  /// @param runs  the heads of these rows, which cover them; begin counts from row 0.
  void Forward(const kernels::Matrix& input, Activations& rows, std::size_t first,
               std::size_t count, const std::vector<HeadRun>& runs) const;

  [[nodiscard]] PackedLayer& hidden(std::size_t i) { return hidden_[i]; }
  [[nodiscard]] PackedLayer& head(std::size_t i) { return heads_[i]; }

  static constexpr std::size_t kRows = 24;  // a good number of rows at once

 private:
  bool normalised_;
  std::vector<PackedLayer> hidden_;
  std::vector<PackedLayer> heads_;  // [k]
};

/// The rows of one head inside the head layer.
LayerSlice HeadSlice(const MlpLayout& layout, std::int32_t head);

}  // namespace metronome::policy
