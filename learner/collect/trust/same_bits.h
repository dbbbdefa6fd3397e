#pragma once

#include "common/messages/episode.h"

namespace metronome::collect::trust {

/// Equal in every bit (== would let -0 pass for 0).
bool SameBits(const Episode& a, const Episode& b);

}  // namespace metronome::collect::trust
