#pragma once

#include <array>
#include <cstdint>

namespace metronome::render {

using Color = std::array<std::uint8_t, 3>;  // red, green, blue; sRGB bytes

/// The colour of head `head` of `heads`, the one that a figure made with matplotlib gives it: up to
/// ten heads take `tab10` in order, more are spread over `rainbow`, that is
/// `matplotlib.colormaps["rainbow"](head / (heads - 1), bytes=True)`.
/// @throws std::out_of_range unless 0 <= head < heads.
Color HeadColor(std::int32_t head, std::int32_t heads);

/// Black or white, whichever is easier to read on `background`.
Color TextColorOn(const Color& background);

}  // namespace metronome::render
