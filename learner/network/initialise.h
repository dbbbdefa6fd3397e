#pragma once

#include <cstdint>
#include <vector>

#include "common/policy/network.h"

namespace metronome::network {

/// First weights of a run's networks, one after the other: orthogonal (Saxe et al.,
/// arXiv:1312.6120) with gain sqrt 2 in hidden layers and a given one in each head; zero biases. A
/// pure function of the seed and of the networks asked for before.
class Initialiser {
 public:
  explicit Initialiser(std::uint64_t seed) : seed_(seed) {}

  /// @return layout.size floats; what is neither weight nor bias is zero.
  std::vector<float> Network(const policy::MlpLayout& layout, double head_gain);

 private:
  void Rows(const policy::LayerSlice& slice, std::int32_t first, std::int32_t rows, double gain,
            std::vector<float>& parameters);

  std::uint64_t seed_;
  std::uint64_t block_ = 0;
};

}  // namespace metronome::network
