#include "learner/ppo/initialise.h"

#include <algorithm>
#include <cmath>

#include "common/numbers/orthogonal.h"
#include "common/numbers/random.h"

namespace metronome::ppo {
namespace {

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
    const std::vector<double> weight = numbers::Orthogonal(
        rows, slice.inputs, {numbers::RandomPurpose::kInitialise, seed_, block_++, 0});
    float* to = parameters_ + slice.weight +
                static_cast<std::size_t>(first) * static_cast<std::size_t>(slice.inputs);
    for (const double number : weight) *to++ = static_cast<float>(gain * number);
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
