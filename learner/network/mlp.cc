#include "learner/network/mlp.h"

#include <algorithm>
#include <array>
#include <utility>

#include "common/kernels/product.h"
#include "common/policy/rms_norm.h"

namespace metronome::network {
namespace {

using kernels::kPanel;
using kernels::Matrix;

// Parameters of a part of the gradient: its sums stay in the first cache, and so do a group's
// samples that they are of. Whole panels.
constexpr std::size_t kPartOutputs = 3 * kPanel;
constexpr std::size_t kPartInputs = 4 * kPanel;

constexpr float kOne = 1;

// Panels of a weight [outputs, inputs] as it is, of so many of its inputs.
Matrix BackwardPanels(const policy::LayerSlice& slice, std::size_t inputs) {
  return {kernels::PanelsOf(inputs), std::size_t(slice.outputs) * kPanel};
}

// Up to kPanel numbers; almost always all of them, which takes no call.
void CopyPanel(const float* from, std::size_t count, float* to) {
  if (count == kPanel) {
    std::copy_n(from, kPanel, to);
  } else {
    std::copy_n(from, count, to);
  }
}

// d_below = d * weight, of `count` rows.
void MultiplyBack(const Matrix& panels, const Matrix& d, std::size_t first, std::size_t count,
                  Matrix& d_below) {
  kernels::Product product;
  product.rows = count;
  product.columns = d_below.columns();
  product.depth = d.columns();
  product.left = d.row(first);
  product.left_row = d.stride();
  product.right = panels.data();
  product.right_panel = panels.stride();
  product.out = d_below.row(first);
  product.out_row = d_below.stride();
  kernels::Multiply(product);
}

// Sum of squares in kPanel chains, each in order, then in order of the chains.
class SumOfSquares {
 public:
  void Add(const float* values, std::size_t count) {
    std::size_t i = 0;
    for (; i + kPanel <= count; i += kPanel) {
      for (std::size_t c = 0; c < kPanel; ++c) AddTo(c, values[i + c]);
    }
    for (std::size_t c = 0; i < count; ++i, ++c) AddTo(c, values[i]);
  }
  [[nodiscard]] double total() const {
    double sum = 0;
    for (const double chain : chains_) sum += chain;
    return sum;
  }

 private:
  void AddTo(std::size_t chain, float value) { chains_[chain] += double{value} * value; }

  std::array<double, kPanel> chains_{};
};

// The run of a head; of no rows where it has none.
policy::HeadRun RunOf(const std::vector<policy::HeadRun>& runs, std::int32_t head) {
  const auto run = std::find_if(runs.begin(), runs.end(),
                                [head](const policy::HeadRun& of) { return of.head == head; });
  return run == runs.end() ? policy::HeadRun{head} : *run;
}

}  // namespace

Mlp::Mlp(policy::MlpLayout layout, std::size_t rows, std::size_t inputs_with_gradient,
         bool backward)
    : layout_(std::move(layout)),
      forward_(layout_),
      rows_(layout_, rows),
      d_output_(rows, std::size_t(layout_.head_outputs)),
      d_input_(rows, inputs_with_gradient) {
  for (std::size_t i = 0; i < layout_.hidden.size(); ++i) {
    d_hidden_.emplace_back(rows, std::size_t(layout_.hidden[i].outputs));
    const std::size_t inputs =
        i == 0 ? inputs_with_gradient : std::size_t(layout_.hidden[i].inputs);
    backward_hidden_.push_back(BackwardPanels(layout_.hidden[i], backward ? inputs : 0));
    AddParts(layout_.hidden[i], i, 0);
  }
  for (std::int32_t head = 0; head < layout_.heads; ++head) {
    const policy::LayerSlice slice = policy::HeadSlice(layout_, head);
    const std::size_t inputs = d_hidden_.empty() || !backward ? 0 : std::size_t(slice.inputs);
    backward_heads_.push_back(BackwardPanels(slice, inputs));
    AddParts(slice, layout_.hidden.size(), std::size_t(head));
  }
}

void Mlp::AddParts(const policy::LayerSlice& slice, std::size_t layer, std::size_t head) {
  const auto outputs = std::size_t(slice.outputs);
  const auto inputs = std::size_t(slice.inputs);
  Part part{slice, layer, head};
  part.inputs = inputs;
  for (; part.first_output < outputs; part.first_output += kPanel) {
    part.outputs = std::min(kPanel, outputs - part.first_output);
    weight_parts_.push_back(part);
  }
  for (part.first_output = 0; part.first_output < outputs; part.first_output += kPartOutputs) {
    part.outputs = std::min(kPartOutputs, outputs - part.first_output);
    for (part.first_input = 0; part.first_input < inputs; part.first_input += kPartInputs) {
      part.inputs = std::min(kPartInputs, inputs - part.first_input);
      gradient_parts_.push_back(part);
    }
  }
}

std::vector<ParameterRange> Mlp::RangesOf(std::size_t weight_part) const {
  const Part& part = weight_parts_[weight_part];
  return {{part.slice.weight + part.first_output * part.inputs, part.outputs * part.inputs},
          {part.slice.bias + part.first_output, part.outputs}};
}

void Mlp::Pack(std::size_t weight_part, const float* parameters) {
  const Part& part = weight_parts_[weight_part];
  const float* weight = parameters + part.slice.weight;
  policy::PackedLayer& layer =
      IsHead(part) ? forward_.head(part.head) : forward_.hidden(part.layer);
  layer.PackPanel(part.first_output / kPanel, weight, parameters + part.slice.bias);
  Matrix& panels = IsHead(part) ? backward_heads_[part.head] : backward_hidden_[part.layer];
  const bool of_input = !IsHead(part) && part.layer == 0;
  const std::size_t first = of_input ? part.inputs - d_input_.columns() : 0;
  for (std::size_t panel = 0; panel < panels.rows(); ++panel) {
    const std::size_t input = first + panel * kPanel;
    const std::size_t count = std::min(kPanel, part.inputs - input);
    for (std::size_t o = part.first_output; o < part.first_output + part.outputs; ++o) {
      CopyPanel(weight + o * part.inputs + input, count, panels.row(panel) + o * kPanel);
    }
  }
}

void Mlp::PackHeads(const float* parameters) {
  for (std::size_t part = 0; part < weight_parts_.size(); ++part) {
    if (IsHead(weight_parts_[part])) Pack(part, parameters);
  }
}

void Mlp::Forward(const Matrix& input, std::size_t first, std::size_t count,
                  const std::vector<policy::HeadRun>& runs) {
  forward_.Forward(input, rows_, first, count, runs);
}

void Mlp::Backward(std::size_t first, std::size_t count, const std::vector<policy::HeadRun>& runs) {
  if (d_hidden_.empty()) return;
  for (const policy::HeadRun& run : runs) {
    MultiplyBack(backward_heads_[std::size_t(run.head)], d_output_, run.begin, run.count,
                 d_hidden_.back());
  }
  for (std::size_t i = d_hidden_.size(); i-- > 0;) {
    Matrix& d = d_hidden_[i];
    kernels::TimesTanhSlope(rows_.hidden[i].row(first), d.row(first),
                            {count, d.columns(), d.stride()});
    if (layout_.normalised) {
      for (std::size_t row = first; row < first + count; ++row) {
        policy::BackThroughRms(rows_.normalised[i].row(row), rows_.inv_rms[i][row], d.row(row),
                               d.columns());
      }
    }
    Matrix& below = i > 0 ? d_hidden_[i - 1] : d_input_;
    if (below.columns() > 0) MultiplyBack(backward_hidden_[i], d, first, count, below);
  }
}

double Mlp::Gradient(std::size_t gradient_part, const Matrix& input, const SampleGroups& groups,
                     const std::vector<policy::HeadRun>& runs, float* gradient) const {
  const Part& part = gradient_parts_[gradient_part];
  const policy::HeadRun rows =
      IsHead(part) ? RunOf(runs, std::int32_t(part.head)) : policy::HeadRun{0, 0, groups.samples};
  const Matrix& d = IsHead(part) ? d_output_ : d_hidden_[part.layer];
  const Matrix& below = part.layer == 0 ? input : rows_.hidden[part.layer - 1];
  alignas(64) std::array<float, kPartOutputs * kPartInputs> weight{};
  std::array<float, kPartOutputs> bias{};
  kernels::Product of_weight;
  of_weight.rows = part.outputs;
  of_weight.columns = part.inputs;
  of_weight.left_row = 1;
  of_weight.left_step = d.stride();
  of_weight.right_panel = kPanel;
  of_weight.right_step = below.stride();
  of_weight.out = weight.data();
  of_weight.out_row = kPartInputs;
  of_weight.add = true;
  kernels::Product of_bias;  // 1 * d: fma(1, d, s) is d + s
  of_bias.rows = 1;
  of_bias.columns = part.outputs;
  of_bias.left = &kOne;
  of_bias.left_step = 0;
  of_bias.right_panel = kPanel;
  of_bias.right_step = d.stride();
  of_bias.out = bias.data();
  of_bias.add = true;
  for (std::size_t g = 0; g < SampleGroups::kGroups; ++g) {
    const policy::HeadRun of_group = groups.PartOf(rows, g);
    if (of_group.count == 0) continue;
    of_weight.depth = of_bias.depth = of_group.count;
    of_weight.left = of_bias.right = d.row(of_group.begin) + part.first_output;
    of_weight.right = below.row(of_group.begin) + part.first_input;
    kernels::Multiply(of_weight);
    if (part.first_input == 0) kernels::Multiply(of_bias);
  }
  SumOfSquares squares;
  for (std::size_t o = 0; o < part.outputs; ++o) {
    const float* row = weight.data() + o * kPartInputs;
    const std::size_t at = (part.first_output + o) * std::size_t(part.slice.inputs);
    std::copy_n(row, part.inputs, gradient + part.slice.weight + at + part.first_input);
    squares.Add(row, part.inputs);
  }
  if (part.first_input == 0) {
    std::copy_n(bias.data(), part.outputs, gradient + part.slice.bias + part.first_output);
    squares.Add(bias.data(), part.outputs);
  }
  return squares.total();
}

}  // namespace metronome::network
