#include "learner/network/initialise.h"

#include <cmath>
#include <cstddef>

#include "common/numbers/orthogonal.h"
#include "common/numbers/random.h"

namespace metronome::network {

std::vector<float> Initialiser::Network(const policy::MlpLayout& layout, double head_gain) {
  std::vector<float> parameters(layout.size, 0.0F);
  for (const policy::LayerSlice& slice : layout.hidden) {
    Rows(slice, 0, slice.outputs, std::sqrt(2.0), parameters);
  }
  for (std::int32_t head = 0; head < layout.heads; ++head) {
    Rows(layout.head, head * layout.head_outputs, layout.head_outputs, head_gain, parameters);
  }
  return parameters;
}

// Each block of rows has a random stream of its own.
void Initialiser::Rows(const policy::LayerSlice& slice, std::int32_t first, std::int32_t rows,
                       double gain, std::vector<float>& parameters) {
  const std::vector<double> weight = numbers::Orthogonal(
      rows, slice.inputs, {numbers::RandomPurpose::kInitialise, seed_, block_++, 0});
  float* to = parameters.data() + slice.weight + std::size_t(first) * std::size_t(slice.inputs);
  for (const double number : weight) *to++ = static_cast<float>(gain * number);
}

}  // namespace metronome::network
