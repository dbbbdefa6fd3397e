#include "common/numbers/random.h"

#include <Random123/philox.h>

#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "common/numbers/elementary.h"

namespace metronome::numbers {

RandomStream::RandomStream(RandomPurpose purpose, std::uint64_t seed, std::uint64_t number,
                           std::uint64_t t)
    : key_{seed, static_cast<std::uint64_t>(purpose)}, counter_{0, number, t, 0} {}

std::uint64_t RandomStream::Bits() {
  if (used_ == 4) {
    const r123::Philox4x64::ctr_type counter = {
        {counter_[0], counter_[1], counter_[2], counter_[3]}};
    const r123::Philox4x64::key_type key = {{key_[0], key_[1]}};
    const auto block = r123::Philox4x64{}(counter, key);
    for (int i = 0; i < 4; ++i) block_[i] = block[i];
    ++counter_[0];
    used_ = 0;
  }
  return block_[used_++];
}

double RandomStream::Uniform() { return static_cast<double>(Bits() >> 11) * 0x1p-53; }

double RandomStream::Normal() {
  if (has_spare_normal_) {
    has_spare_normal_ = false;
    return spare_normal_;
  }
  const double radius = std::sqrt(-2.0 * Log(1.0 - Uniform()));  // argument in (0, 1]
  const double angle = 2.0 * M_PI * Uniform();
  spare_normal_ = radius * Sin(angle);
  has_spare_normal_ = true;
  return radius * Cos(angle);
}

std::uint64_t RandomStream::Below(std::uint64_t bound) {
  if (bound == 0) throw std::invalid_argument("RandomStream::Below needs a positive bound");
  const std::uint64_t reject_below = (0 - bound) % bound;  // 2^64 mod bound
  for (;;) {
    const std::uint64_t bits = Bits();
    if (bits >= reject_below) return bits % bound;
  }
}

std::vector<std::uint32_t> Permutation(std::uint32_t size, RandomStream stream) {
  std::vector<std::uint32_t> permutation(size);
  std::iota(permutation.begin(), permutation.end(), 0U);
  for (std::uint32_t i = size; i > 1; --i)
    std::swap(permutation[i - 1], permutation[stream.Below(i)]);
  return permutation;
}

}  // namespace metronome::numbers
