#include "learner/network/shared_heads.h"

#include <algorithm>

namespace metronome::network {
namespace {

// The sum over heads, in their order.
std::vector<float> SumOf(const float* pieces, std::size_t size, std::size_t heads) {
  std::vector<float> sum(size, 0.0F);
  for (std::size_t head = 0; head < heads; ++head, pieces += size) {
    for (std::size_t i = 0; i < size; ++i) sum[i] += pieces[i];
  }
  return sum;
}

}  // namespace

SharedHeads::SharedHeads(const std::vector<policy::MlpLayout>& networks) {
  std::size_t offset = 0;
  for (const policy::MlpLayout& layout : networks) {
    AddNetwork(layout, offset);
    offset += layout.size;
  }
}

void SharedHeads::AddNetwork(const policy::MlpLayout& layout, std::size_t offset) {
  if (layout.heads < 2) return;
  const auto add = [&](std::size_t first, std::size_t size) {
    pieces_.push_back({offset + first, size, std::size_t(layout.heads)});
    size_ += size;
  };
  const auto outputs = std::size_t(layout.head_outputs);
  add(layout.head.weight, outputs * std::size_t(layout.head.inputs));
  add(layout.head.bias, outputs);
}

void SharedHeads::MakeEqual(std::vector<float>& parameters) const {
  for (const Pieces& pieces : pieces_) {
    const float* first = parameters.data() + pieces.first;
    for (std::size_t head = 1; head < pieces.heads; ++head) {
      std::copy_n(first, pieces.size, parameters.data() + pieces.first + head * pieces.size);
    }
  }
}

void SharedHeads::Step(const Adam& adam, const float* gradient, float decay, Moments& moments,
                       float* parameters) const {
  std::size_t at = 0;
  for (const Pieces& pieces : pieces_) {
    const std::vector<float> sum = SumOf(gradient + pieces.first, pieces.size, pieces.heads);
    std::vector<float> step(pieces.size, 0.0F);
    adam.Apply(sum.data(), step.data(), moments.m.data() + at, moments.v.data() + at, pieces.size);
    float* of_head = parameters + pieces.first;
    const std::vector<float> total = SumOf(of_head, pieces.size, pieces.heads);
    for (std::size_t head = 0; head < pieces.heads; ++head, of_head += pieces.size) {
      for (std::size_t i = 0; i < pieces.size; ++i) {
        const float apart = of_head[i] - total[i] / float(pieces.heads);
        of_head[i] += step[i] - decay * apart;
      }
    }
    at += pieces.size;
  }
}

}  // namespace metronome::network
