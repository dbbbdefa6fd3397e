#pragma once

#include <cstddef>
#include <cstdint>

#include "common/schema/config.pb.h"

namespace metronome::policy {

/// Which of the run's environments training episode `number` is played in, counted from 0: like the
/// head schedule a pure function, so that assignments and episodes need not say it. A run has one.
inline std::size_t TaskOf(const RunConfig& /*config*/, std::uint64_t /*number*/) { return 0; }

}  // namespace metronome::policy
