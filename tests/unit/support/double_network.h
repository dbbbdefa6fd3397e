#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "common/policy/network.h"

namespace metronome::testing {

/// Outputs of one head of a network in double precision, from its definition: tanh layers (whose
/// sums are divided by their root mean square if normalised), then the rows of the head.
/// @param parameters  the network's block, MlpLayout assignment.
/// @param x           the network's input.
template <typename Number>
std::vector<double> Forward(const std::vector<Number>& parameters, const policy::MlpLayout& layout,
                            std::vector<double> x, int head) {
  const auto apply = [&](const policy::LayerSlice& slice, int first, int rows) {
    std::vector<double> y;
    for (int r = first; r < first + rows; ++r) {
      double sum = parameters[slice.bias + std::size_t(r)];
      for (int c = 0; c < slice.inputs; ++c) {
        sum += double{parameters[slice.weight + std::size_t(r * slice.inputs + c)]} *
               x[std::size_t(c)];
      }
      y.push_back(sum);
    }
    return y;
  };
  for (const policy::LayerSlice& slice : layout.hidden) {
    x = apply(slice, 0, slice.outputs);
    double squares = 0;
    for (const double sum : x) squares += sum * sum / double(x.size());
    const double scale = layout.normalised ? 1 / std::sqrt(squares + 1e-5) : 1;
    for (double& sum : x) sum = std::tanh(scale * sum);
  }
  return apply(layout.head, head * layout.head_outputs, layout.head_outputs);
}

}  // namespace metronome::testing
