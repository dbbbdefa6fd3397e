#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace metronome::numbers {

/// The purpose of a random number. Streams of different purposes never meet.
/// The values are part of the promise of bit-equality: never renumber.
enum class RandomPurpose : std::uint64_t {
  kTrain = 1,
  kEvaluate = 2,
  kInitialise = 3,
  kShuffle = 4,
  kHeadPermutation = 5,
  kAudit = 6,
  kCheck = 7,
  kReplay = 8,      // which steps a gradient step of SAC learns from
  kUpdateNoise = 9  // of the actions that it tries
};

/// Which draw inside a train or evaluate episode; see RandomStream's `t`.
/// Steps use t = 0..T-1, so the marker lies far outside them.
inline constexpr std::uint64_t kPlacementDraw = ~std::uint64_t{0};

/// A counter-based random stream: a pure function of (purpose, seed, number, t), so that nothing
/// else - no actor, no clock, no earlier draw elsewhere - can enter.
/// Generator: Philox4x64-10 of Random123 (Salmon et al., SC'11), key = {seed, purpose},
/// counter = {block, number, t, 0}. Not thread-safe; make one where it is used, it is cheap.
class RandomStream {
 public:
  RandomStream(RandomPurpose purpose, std::uint64_t seed, std::uint64_t number, std::uint64_t t);

  /// 64 uniform bits.
  std::uint64_t Bits();
  /// Uniform in [0, 1), 53 bits.
  double Uniform();
  /// Standard normal, by the Box-Muller transform in double precision (two uniforms a pair).
  double Normal();
  /// Uniform integer in [0, bound), without modulo bias. @throws std::invalid_argument if bound is
  /// 0.
  std::uint64_t Below(std::uint64_t bound);

 private:
  std::array<std::uint64_t, 2> key_;
  std::array<std::uint64_t, 4> counter_;
  std::array<std::uint64_t, 4> block_{};
  int used_ = 4;
  double spare_normal_ = 0;
  bool has_spare_normal_ = false;
};

/// A uniform permutation of 0..size-1 (Fisher-Yates), a function of the stream's key and counter.
std::vector<std::uint32_t> Permutation(std::uint32_t size, RandomStream stream);

}  // namespace metronome::numbers
