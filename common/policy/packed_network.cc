#include "common/policy/packed_network.h"

#include <algorithm>

#include "common/kernels/product.h"
#include "common/policy/rms_norm.h"

namespace metronome::policy {

using kernels::kPanel;

namespace {

void NormaliseRows(Activations& rows, std::size_t layer, std::size_t first, std::size_t count) {
  kernels::Matrix& sums = rows.hidden[layer];
  for (std::size_t row = first; row < first + count; ++row) {
    rows.inv_rms[layer][row] = NormaliseByRms(sums.row(row), sums.columns());
    std::copy_n(sums.row(row), sums.columns(), rows.normalised[layer].row(row));
  }
}

}  // namespace

PackedLayer::PackedLayer(std::int32_t inputs, std::int32_t outputs)
    : inputs_(std::size_t(inputs)),
      outputs_(std::size_t(outputs)),
      panels_(kernels::PanelsOf(outputs_), inputs_ * kPanel),
      bias_(1, outputs_) {}

void PackedLayer::Pack(const float* weight, const float* bias) {
  for (std::size_t panel = 0; panel < panels_.rows(); ++panel) PackPanel(panel, weight, bias);
}

void PackedLayer::PackPanel(std::size_t panel, const float* weight, const float* bias) {
  const std::size_t first = panel * kPanel;
  const std::size_t count = std::min(kPanel, outputs_ - first);
  float* packed = panels_.row(panel);
  for (std::size_t i = 0; i < inputs_; ++i) {
    for (std::size_t o = 0; o < count; ++o) {
      packed[i * kPanel + o] = weight[(first + o) * inputs_ + i];
    }
  }
  std::copy_n(bias + first, count, bias_.data() + first);
}

void PackedLayer::Forward(const float* input, std::size_t input_row, std::size_t rows,
                          float* output, std::size_t output_row) const {
  kernels::Product product;
  product.rows = rows;
  product.columns = outputs_;
  product.depth = inputs_;
  product.left = input;
  product.left_row = input_row;
  product.right = panels_.data();
  product.right_panel = panels_.stride();
  product.start = bias_.data();
  product.out = output;
  product.out_row = output_row;
  kernels::Multiply(product);
}

void AddRow(std::int32_t head, std::size_t row, std::vector<HeadRun>& runs) {
  if (runs.empty() || runs.back().head != head) runs.push_back({head, row, 0});
  ++runs.back().count;
}

std::vector<HeadRun> ValueRuns(const std::vector<HeadRun>& runs, const NetworkShape& shape) {
  std::vector<HeadRun> value_runs;
  for (const HeadRun& run : runs) {
    const std::int32_t head = shape.value_head(run.head);
    if (value_runs.empty() || value_runs.back().head != head) {
      value_runs.push_back({head, run.begin, 0});
    }
    value_runs.back().count += run.count;
  }
  return value_runs;
}

Activations::Activations(const MlpLayout& layout, std::size_t rows)
    : output(rows, std::size_t(layout.head_outputs)) {
  for (const LayerSlice& slice : layout.hidden) {
    hidden.emplace_back(rows, slice.outputs);
    if (!layout.normalised) continue;
    normalised.emplace_back(rows, slice.outputs);
    inv_rms.emplace_back(rows);
  }
}

PackedNetwork::PackedNetwork(const MlpLayout& layout) : normalised_(layout.normalised) {
  for (const LayerSlice& slice : layout.hidden) hidden_.emplace_back(slice.inputs, slice.outputs);
  for (std::int32_t head = 0; head < layout.heads; ++head) {
    heads_.emplace_back(layout.head.inputs, layout.head_outputs);
  }
}

PackedNetwork::PackedNetwork(const MlpLayout& layout, const float* parameters)
    : PackedNetwork(layout) {
  for (std::size_t i = 0; i < hidden_.size(); ++i) {
    hidden_[i].Pack(parameters + layout.hidden[i].weight, parameters + layout.hidden[i].bias);
  }
  for (std::size_t head = 0; head < heads_.size(); ++head) {
    const LayerSlice slice = HeadSlice(layout, std::int32_t(head));
    heads_[head].Pack(parameters + slice.weight, parameters + slice.bias);
  }
}

void PackedNetwork::Forward(const kernels::Matrix& input, Activations& rows, std::size_t first,
                            std::size_t count, const std::vector<HeadRun>& runs) const {
  const kernels::Matrix* below = &input;
  for (std::size_t i = 0; i < hidden_.size(); ++i) {
    kernels::Matrix& out = rows.hidden[i];
    hidden_[i].Forward(below->row(first), below->stride(), count, out.row(first), out.stride());
    if (normalised_) NormaliseRows(rows, i, first, count);
    kernels::Tanh(out.row(first), {count, out.columns(), out.stride()});
    below = &out;
  }
  for (const HeadRun& run : runs) {
    heads_[std::size_t(run.head)].Forward(below->row(run.begin), below->stride(), run.count,
                                          rows.output.row(run.begin), rows.output.stride());
  }
}

LayerSlice HeadSlice(const MlpLayout& layout, std::int32_t head) {
  LayerSlice slice = layout.head;
  const auto first = std::size_t(head) * std::size_t(layout.head_outputs);
  slice.weight += first * std::size_t(slice.inputs);
  slice.bias += first;
  slice.outputs = layout.head_outputs;
  return slice;
}

}  // namespace metronome::policy
