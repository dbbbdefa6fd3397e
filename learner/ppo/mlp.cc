#include "learner/ppo/mlp.h"

#include <algorithm>
#include <utility>

#include "common/policy/activation.h"

namespace metronome::ppo {
namespace {

using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using ConstWeight = Eigen::Map<const RowMajor>;
using ConstBias = Eigen::Map<const Eigen::VectorXf>;
using Weight = Eigen::Map<RowMajor>;

// Rows of a head inside the head layer.
policy::LayerSlice HeadSlice(const policy::MlpLayout& layout, std::int32_t head) {
  policy::LayerSlice slice = layout.head;
  const std::int32_t first = head * layout.head_outputs;
  slice.weight += static_cast<std::size_t>(first) * static_cast<std::size_t>(slice.inputs);
  slice.bias += static_cast<std::size_t>(first);
  slice.outputs = layout.head_outputs;
  return slice;
}

ConstWeight WeightOf(const float* parameters, const policy::LayerSlice& slice) {
  return {parameters + slice.weight, slice.outputs, slice.inputs};
}

ConstBias BiasOf(const float* parameters, const policy::LayerSlice& slice) {
  return {parameters + slice.bias, slice.outputs};
}

// Column by column, so that the order of the sum is written here and does not follow alignment.
template <typename Columns>
void AddColumns(const Columns& columns, float* sum) {
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    for (Eigen::Index r = 0; r < columns.rows(); ++r) sum[r] += columns(r, c);
  }
}

}  // namespace

std::vector<HeadRun> ValueRuns(const std::vector<HeadRun>& runs,
                               const policy::NetworkShape& shape) {
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

Mlp::Mlp(policy::MlpLayout layout)
    : layout_(std::move(layout)),
      activation_(layout_.hidden.size()),
      d_activation_(layout_.hidden.size()) {}

const Eigen::MatrixXf& Mlp::Forward(const float* parameters, const Eigen::MatrixXf& input,
                                    const std::vector<HeadRun>& runs) {
  const Eigen::MatrixXf* below = &input;
  for (std::size_t i = 0; i < layout_.hidden.size(); ++i) {
    const policy::LayerSlice& slice = layout_.hidden[i];
    activation_[i].resize(slice.outputs, input.cols());
    activation_[i].colwise() = BiasOf(parameters, slice);
    activation_[i].noalias() += WeightOf(parameters, slice) * *below;
    policy::TanhInPlace(activation_[i]);
    below = &activation_[i];
  }
  output_.resize(layout_.head_outputs, input.cols());
  for (const HeadRun& run : runs) {
    const policy::LayerSlice slice = HeadSlice(layout_, run.head);
    auto columns = output_.middleCols(run.begin, run.count);
    columns.colwise() = BiasOf(parameters, slice);
    columns.noalias() += WeightOf(parameters, slice) * below->middleCols(run.begin, run.count);
  }
  return output_;
}

void Mlp::Backward(const float* parameters, const Eigen::MatrixXf& input,
                   const std::vector<HeadRun>& runs, const Eigen::MatrixXf& d_output,
                   float* gradient) {
  const std::size_t layers = layout_.hidden.size();
  const Eigen::MatrixXf& top = layers == 0 ? input : activation_.back();
  Eigen::MatrixXf* d_top = layers == 0 ? nullptr : &d_activation_.back();
  if (d_top != nullptr) d_top->resize(top.rows(), top.cols());
  for (const HeadRun& run : runs) {
    const policy::LayerSlice slice = HeadSlice(layout_, run.head);
    const auto d_columns = d_output.middleCols(run.begin, run.count);
    Weight(gradient + slice.weight, slice.outputs, slice.inputs).noalias() +=
        d_columns * top.middleCols(run.begin, run.count).transpose();
    AddColumns(d_columns, gradient + slice.bias);
    if (d_top != nullptr) {
      d_top->middleCols(run.begin, run.count).noalias() =
          WeightOf(parameters, slice).transpose() * d_columns;
    }
  }
  for (std::size_t i = layers; i-- > 0;) {
    const policy::LayerSlice& slice = layout_.hidden[i];
    Eigen::MatrixXf& d = d_activation_[i];
    d.array() *= 1.0F - activation_[i].array().square();
    const Eigen::MatrixXf& below = i == 0 ? input : activation_[i - 1];
    Weight(gradient + slice.weight, slice.outputs, slice.inputs).noalias() += d * below.transpose();
    AddColumns(d, gradient + slice.bias);
    if (i > 0) {
      d_activation_[i - 1].resize(below.rows(), below.cols());
      d_activation_[i - 1].noalias() = WeightOf(parameters, slice).transpose() * d;
    }
  }
}

}  // namespace metronome::ppo
