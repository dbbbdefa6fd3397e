#include "actor/render/head_colors.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace metronome::render {
namespace {

constexpr std::array<Color, 10> kTab10 = {{{0x1f, 0x77, 0xb4},
                                           {0xff, 0x7f, 0x0e},
                                           {0x2c, 0xa0, 0x2c},
                                           {0xd6, 0x27, 0x28},
                                           {0x94, 0x67, 0xbd},
                                           {0x8c, 0x56, 0x4b},
                                           {0xe3, 0x77, 0xc2},
                                           {0x7f, 0x7f, 0x7f},
                                           {0xbc, 0xbd, 0x22},
                                           {0x17, 0xbe, 0xcf}}};

std::uint8_t Byte(double share) {
  return static_cast<std::uint8_t>(std::clamp(share, 0.0, 1.0) * 255);  // truncated, as matplotlib
}

/// matplotlib's "rainbow": gnuplot's formulae 33, 13 and 10, in a table of 256 entries.
Color Rainbow(double place) {
  const double x = std::min(255.0, std::floor(place * 256)) / 255;
  return {Byte(std::abs(2 * x - 0.5)), Byte(std::sin(x * std::numbers::pi)),
          Byte(std::cos(x * std::numbers::pi / 2))};
}

}  // namespace

Color HeadColor(std::int32_t head, std::int32_t heads) {
  if (head < 0 || head >= heads) {
    throw std::out_of_range("head " + std::to_string(head) + " of " + std::to_string(heads) +
                            " has no colour");
  }
  if (heads <= static_cast<std::int32_t>(kTab10.size())) return kTab10.at(std::size_t(head));
  return Rainbow(static_cast<double>(head) / (heads - 1));
}

Color TextColorOn(const Color& background) {
  const double brightness = 0.299 * background[0] + 0.587 * background[1] + 0.114 * background[2];
  return brightness > 150 ? Color{0, 0, 0} : Color{255, 255, 255};
}

}  // namespace metronome::render
