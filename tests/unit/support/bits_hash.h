#pragma once

#include <bit>
#include <cstdint>

namespace metronome::testing {

/// Of the bits of numbers, one after the other: for tests that pin them. FNV-1a over words, folded:
/// without that, two changed signs would cancel.
class BitsHash {
 public:
  void Add(double number) { Add(std::bit_cast<std::uint64_t>(number)); }
  void Add(float number) { Add(std::uint64_t{std::bit_cast<std::uint32_t>(number)}); }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  void Add(std::uint64_t bits) {
    value_ = (value_ ^ bits) * 0x100000001b3U;
    value_ ^= value_ >> 32;
  }

  std::uint64_t value_ = 0xcbf29ce484222325U;
};

}  // namespace metronome::testing
