#include "learner/ppo/initialise.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "common/numbers/random.h"

namespace metronome::ppo {
namespace {

// Rows (or columns, whichever are fewer) orthonormal, times gain.
Eigen::MatrixXd Orthogonal(std::int32_t rows, std::int32_t columns, double gain,
                           numbers::RandomStream random) {
  const std::int32_t tall = std::max(rows, columns);
  const std::int32_t narrow = std::min(rows, columns);
  Eigen::MatrixXd normal(tall, narrow);
  for (std::int32_t c = 0; c < narrow; ++c) {
    for (std::int32_t r = 0; r < tall; ++r) normal(r, c) = random.Normal();
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(normal);
  Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(tall, narrow);
  // Signs of R's diagonal made positive: the distribution is then uniform.
  for (std::int32_t c = 0; c < narrow; ++c) {
    if (qr.matrixQR()(c, c) < 0) q.col(c) = -q.col(c);
  }
  return gain * (rows >= columns ? q : Eigen::MatrixXd(q.transpose()));
}

class Initialiser {
 public:
  Initialiser(float* parameters, std::uint64_t seed) : parameters_(parameters), seed_(seed) {}

  void Network(const policy::MlpLayout& layout, double head_gain) {
    for (const policy::LayerSlice& slice : layout.hidden) {
      Rows(slice, 0, slice.outputs, std::sqrt(2.0));
    }
    for (std::int32_t head = 0; head < layout.heads; ++head) {
      Rows(layout.head, head * layout.head_outputs, layout.head_outputs, head_gain);
    }
    parameters_ += layout.size;
  }

 private:
  // Each block of rows has a random stream of its own.
  void Rows(const policy::LayerSlice& slice, std::int32_t first, std::int32_t rows, double gain) {
    const Eigen::MatrixXd weight = Orthogonal(
        rows, slice.inputs, gain, {numbers::RandomPurpose::kInitialise, seed_, block_++, 0});
    for (std::int32_t r = 0; r < rows; ++r) {
      for (std::int32_t c = 0; c < slice.inputs; ++c) {
        const std::size_t row = static_cast<std::size_t>(first) + static_cast<std::size_t>(r);
        parameters_[slice.weight + row * static_cast<std::size_t>(slice.inputs) +
                    static_cast<std::size_t>(c)] = static_cast<float>(weight(r, c));
      }
    }
  }

  float* parameters_;
  std::uint64_t seed_;
  std::uint64_t block_ = 0;
};

}  // namespace

std::vector<float> InitialParameters(const policy::NetworkShape& shape, double log_std,
                                     std::uint64_t seed) {
  std::vector<float> parameters(policy::ParameterCount(shape), 0.0F);
  const policy::MlpLayout actor = policy::ActorLayout(shape);
  Initialiser initialiser(parameters.data(), seed);
  initialiser.Network(actor, 0.01);
  initialiser.Network(policy::CriticLayout(shape), 1.0);
  std::fill(parameters.begin() + static_cast<std::ptrdiff_t>(actor.log_std),
            parameters.begin() + static_cast<std::ptrdiff_t>(actor.size),
            static_cast<float>(log_std));
  return parameters;
}

}  // namespace metronome::ppo
