#include "common/policy.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "common/activation.h"
#include "common/gaussian.h"
#include "common/network_input.h"

namespace metronome {
namespace {

using Packet = Eigen::internal::packet_traits<float>::type;
constexpr Eigen::Index kVector = Eigen::internal::packet_traits<float>::size;

}  // namespace

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
    activations_.emplace_back(hidden_.back().padded);
  }
  for (std::int32_t head = 0; head < shape_.heads; ++head) {
    heads_.push_back(Transpose(parameters, layout.head, head * kActionSize, kActionSize));
    head_output_.resize(heads_.back().padded);
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
  layer.padded = (rows + kVector - 1) / kVector * kVector;
  layer.weight_t = Eigen::VectorXf::Zero(layer.padded * slice.inputs);
  const float* weight = parameters + slice.weight + std::size_t(first_row) * slice.inputs;
  for (Eigen::Index row = 0; row < rows; ++row) {
    for (Eigen::Index column = 0; column < slice.inputs; ++column) {
      layer.weight_t[column * layer.padded + row] = weight[row * slice.inputs + column];
    }
  }
  layer.bias = Eigen::VectorXf::Zero(layer.padded);
  layer.bias.head(rows) =
      Eigen::Map<const Eigen::VectorXf>(parameters + slice.bias + first_row, rows);
  return layer;
}

/// Outputs [first, first + Vectors * kVector) of a layer, whose sums stay in registers.
template <int Vectors>
void Policy::ApplyTo(const Layer& layer, Eigen::Index first, const float* input, float* output) {
  using namespace Eigen::internal;
  Packet sums[Vectors];
  for (int v = 0; v < Vectors; ++v) {
    sums[v] = pload<Packet>(layer.bias.data() + first + v * kVector);
  }
  const float* weight = layer.weight_t.data() + first;
  for (std::int32_t i = 0; i < layer.inputs; ++i, weight += layer.padded) {
    const Packet x = pset1<Packet>(input[i]);
    for (int v = 0; v < Vectors; ++v) {
      sums[v] = pmadd(pload<Packet>(weight + v * kVector), x, sums[v]);
    }
  }
  for (int v = 0; v < Vectors; ++v) pstore(output + first + v * kVector, sums[v]);
}

void Policy::Apply(const Layer& layer, const float* input, float* output) {
  constexpr int kTogether = 8;  // enough sums to hide an addition's latency
  Eigen::Index first = 0;
  for (; first + kTogether * kVector <= layer.padded; first += kTogether * kVector) {
    ApplyTo<kTogether>(layer, first, input, output);
  }
  for (; first < layer.padded; first += kVector) ApplyTo<1>(layer, first, input, output);
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
  Apply(heads_[head], layer_input, head_output_.data());
  std::array<float, kActionSize> mean{};
  std::copy_n(head_output_.data(), kActionSize, mean.begin());
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
