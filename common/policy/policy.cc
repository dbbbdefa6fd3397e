#include "common/policy/policy.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "common/policy/gaussian.h"
#include "common/policy/network_input.h"

namespace metronome::policy {
namespace {

using Eigen::internal::pload;
using Eigen::internal::pmadd;
using Eigen::internal::pset1;
using Eigen::internal::pstore;
using Eigen::internal::ptanh;
using Packet = Eigen::internal::packet_traits<float>::type;
constexpr Eigen::Index kVector = Eigen::internal::packet_traits<float>::size;

}  // namespace

Policy::Policy(const RunConfig& config, const PolicySnapshot& snapshot)
    : version_(snapshot.version),
      shape_(ShapeOf(config)),
      clip_(static_cast<float>(config.policy().observation_clip())),
      observation_mean_(snapshot.observation_mean),
      observation_inv_std_(snapshot.observation_inv_std),
      input_(shape_.input(), kStates) {
  const MlpLayout layout = ActorLayout(shape_);
  if (snapshot.parameters.size() != layout.size ||
      observation_mean_.size() != shape_.statistics() ||
      observation_inv_std_.size() != shape_.statistics()) {
    throw std::invalid_argument("policy snapshot " + std::to_string(snapshot.version) + " has " +
                                std::to_string(snapshot.parameters.size()) +
                                " parameters, the run's network needs " +
                                std::to_string(layout.size));
  }
  const float* parameters = snapshot.parameters.data();
  for (const LayerSlice& slice : layout.hidden) {
    hidden_.push_back(Transpose(parameters, slice, 0, slice.outputs));
    activations_.emplace_back(hidden_.back().padded, kStates);
  }
  for (std::int32_t head = 0; head < shape_.heads; ++head) {
    heads_.push_back(Transpose(parameters, layout.head, head * shape_.action, shape_.action));
    head_output_.resize(heads_.back().padded);
    const float* log_std = parameters + layout.log_std + head * shape_.action;
    auto& log_stds = log_std_.emplace_back();
    auto& stds = std_.emplace_back();
    for (int i = 0; i < shape_.action; ++i) {
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
template <int States, int Vectors>
void Policy::Layer::ApplyTo(Eigen::Index first, const float* input, Eigen::Index input_stride,
                            float* output, Eigen::Index output_stride) const {
  Packet sums[States][Vectors];
  for (int s = 0; s < States; ++s) {
    for (int v = 0; v < Vectors; ++v) {
      sums[s][v] = pload<Packet>(bias.data() + first + v * kVector);
    }
  }
  const float* weight = weight_t.data() + first;
  for (std::int32_t i = 0; i < inputs; ++i, weight += padded) {
    Packet weights[Vectors];
    for (int v = 0; v < Vectors; ++v) weights[v] = pload<Packet>(weight + v * kVector);
    for (int s = 0; s < States; ++s) {
      const Packet x = pset1<Packet>(input[i + s * input_stride]);
      for (int v = 0; v < Vectors; ++v) sums[s][v] = pmadd(weights[v], x, sums[s][v]);
    }
  }
  for (int s = 0; s < States; ++s) {
    for (int v = 0; v < Vectors; ++v) {
      pstore(output + s * output_stride + first + v * kVector, sums[s][v]);
    }
  }
}

template <int States>
void Policy::Layer::Apply(const float* input, Eigen::Index input_stride, float* output,
                          Eigen::Index output_stride) const {
  constexpr int kTogether = 8 / States;  // eight sums hide an addition's latency
  Eigen::Index first = 0;
  for (; first + kTogether * kVector <= padded; first += kTogether * kVector) {
    ApplyTo<States, kTogether>(first, input, input_stride, output, output_stride);
  }
  for (; first < padded; first += kVector) {
    ApplyTo<States, 1>(first, input, input_stride, output, output_stride);
  }
}

void Policy::RequireFit(const HeadSchedule& schedule) const {
  if (schedule.heads() == shape_.heads) return;
  throw std::invalid_argument("a schedule of " + std::to_string(schedule.heads()) +
                              " heads for a policy of " + std::to_string(shape_.heads));
}

template <int States>
void Policy::MeansOf(const HeadSchedule& schedule, const float* observations, std::int32_t t,
                     Action* means) {
  RequireFit(schedule);
  const Normaliser normaliser{observation_mean_.data(), observation_inv_std_.data(), clip_};
  for (int s = 0; s < States; ++s) {
    WriteInput(shape_, normaliser, observations + s * shape_.observation, schedule.task(), t + s,
               schedule.horizon(), input_.col(s).data());
  }
  const Eigen::MatrixXf* below = &input_;
  for (std::size_t i = 0; i < hidden_.size(); ++i) {
    Eigen::MatrixXf& output = activations_[i];
    hidden_[i].Apply<States>(below->data(), below->rows(), output.data(), output.rows());
    for (Eigen::Index j = 0; j < output.rows() * States; j += kVector) {
      pstore(output.data() + j, ptanh(pload<Packet>(output.data() + j)));
    }
    below = &output;
  }
  for (int s = 0; s < States; ++s) {
    heads_[schedule.HeadAt(t + s)].Apply<1>(below->col(s).data(), 0, head_output_.data(), 0);
    std::copy_n(head_output_.data(), shape_.action, means[s].begin());
  }
}

Policy::Action Policy::Mean(const HeadSchedule& schedule, const float* observation,
                            std::int32_t t) {
  Action mean{};
  MeansOf<1>(schedule, observation, t, &mean);
  return mean;
}

std::array<Policy::Action, Policy::kStates> Policy::Means(const HeadSchedule& schedule,
                                                          const float* observations,
                                                          std::int32_t t) {
  std::array<Action, kStates> means{};
  MeansOf<kStates>(schedule, observations, t, means.data());
  return means;
}

Policy::Decision Policy::Act(const HeadSchedule& schedule, const float* observation, std::int32_t t,
                             const Action& noise) {
  return ActAround(schedule, Mean(schedule, observation, t), t, noise);
}

Policy::Decision Policy::ActAround(const HeadSchedule& schedule, const Action& mean, std::int32_t t,
                                   const Action& noise) const {
  RequireFit(schedule);
  Decision decision;
  decision.mean = mean;
  decision.head = schedule.HeadAt(t);
  const auto& stds = std_[decision.head];
  for (int i = 0; i < shape_.action; ++i) {
    decision.action[i] = decision.mean[i] + stds[i] * noise[i];
  }
  decision.log_prob = GaussianLogProb(decision.action.data(), decision.mean.data(), stds.data(),
                                      log_std_[decision.head].data(), shape_.action);
  return decision;
}

}  // namespace metronome::policy
