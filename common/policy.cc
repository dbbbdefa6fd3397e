#include "common/policy.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "common/activation.h"
#include "common/gaussian.h"
#include "common/network_input.h"

namespace metronome {

Policy::Policy(const RunConfig& config, const PolicySnapshot& snapshot)
    : shape_(ShapeOf(config)),
      schedule_(shape_.heads, config.environment().horizon()),
      clip_(static_cast<float>(config.policy().observation_clip())),
      observation_mean_(snapshot.observation_mean),
      observation_inv_std_(snapshot.observation_inv_std),
      input_(shape_.input()) {
  const MlpLayout layout = ActorLayout(shape_);
  const auto observations = static_cast<std::size_t>(shape_.observation);
  if (snapshot.parameters.size() != layout.size || observation_mean_.size() != observations ||
      observation_inv_std_.size() != observations) {
    throw std::invalid_argument("policy snapshot " + std::to_string(snapshot.version) + " has " +
                                std::to_string(snapshot.parameters.size()) +
                                " parameters, the run's network needs " +
                                std::to_string(layout.size));
  }
  const float* parameters = snapshot.parameters.data();
  for (const LayerSlice& slice : layout.hidden) {
    hidden_.push_back(Transpose(parameters, slice, 0, slice.outputs));
    activations_.emplace_back(slice.outputs);
  }
  for (std::int32_t head = 0; head < shape_.heads; ++head) {
    heads_.push_back(Transpose(parameters, layout.head, head * kActionSize, kActionSize));
    const float* log_std = parameters + layout.log_std + head * kActionSize;
    auto& log_stds = log_std_.emplace_back();
    auto& stds = std_.emplace_back();
    for (int i = 0; i < kActionSize; ++i) {
      log_stds[i] = log_std[i];
      stds[i] = std::exp(log_std[i]);
    }
  }
}

Policy::Layer Policy::Transpose(const float* parameters, const LayerSlice& slice,
                                std::int32_t first_row, std::int32_t rows) {
  Layer layer;
  layer.inputs = slice.inputs;
  layer.outputs = rows;
  const float* weight = parameters + slice.weight + std::size_t(first_row) * slice.inputs;
  layer.weight_t.resize(std::size_t(rows) * slice.inputs);
  for (std::int32_t row = 0; row < rows; ++row) {
    for (std::int32_t column = 0; column < slice.inputs; ++column) {
      layer.weight_t[std::size_t(column) * rows + row] =
          weight[std::size_t(row) * slice.inputs + column];
    }
  }
  const float* bias = parameters + slice.bias + first_row;
  layer.bias.assign(bias, bias + rows);
  return layer;
}

void Policy::Apply(const Layer& layer, const float* input, float* __restrict output) {
  const std::int32_t outputs = layer.outputs;
  std::copy(layer.bias.begin(), layer.bias.end(), output);
  for (std::int32_t i = 0; i < layer.inputs; ++i) {
    const float* __restrict weight = layer.weight_t.data() + std::size_t(i) * outputs;
    const float x = input[i];
    for (std::int32_t j = 0; j < outputs; ++j) output[j] += weight[j] * x;
  }
}

std::array<float, kActionSize> Policy::Mean(const float* observation, std::int32_t t) {
  const std::int32_t head = schedule_.HeadAt(t);
  WriteInput(shape_, observation, observation_mean_.data(), observation_inv_std_.data(), clip_, t,
             schedule_.horizon(), input_.data());
  const float* layer_input = input_.data();
  for (std::size_t i = 0; i < hidden_.size(); ++i) {
    Apply(hidden_[i], layer_input, activations_[i].data());
    TanhInPlace(activations_[i]);
    layer_input = activations_[i].data();
  }
  std::array<float, kActionSize> mean{};
  Apply(heads_[head], layer_input, mean.data());
  return mean;
}

Policy::Decision Policy::Act(const float* observation, std::int32_t t, RandomStream noise) {
  Decision decision;
  decision.mean = Mean(observation, t);
  decision.head = schedule_.HeadAt(t);
  const auto& stds = std_[decision.head];
  for (int i = 0; i < kActionSize; ++i) {
    decision.action[i] = decision.mean[i] + stds[i] * static_cast<float>(noise.Normal());
  }
  decision.log_prob = GaussianLogProb(decision.action.data(), decision.mean.data(), stds.data(),
                                      log_std_[decision.head].data());
  return decision;
}

}  // namespace metronome
