#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "common/schema/config.pb.h"

namespace metronome::policy {

/// Tasks of a run, at least 1.
inline std::size_t TaskCount(const RunConfig& config) {
  return std::max<std::size_t>(1, std::size_t(config.environment().spec().tasks_size()));
}

/// The task of training episode `number`, counted from 0: like the head schedule a pure function,
/// so that assignments and episodes need not say it. The tasks take turns, and a batch is a
/// multiple of their number: each batch has equally many episodes of each.
inline std::size_t TaskOf(const RunConfig& config, std::uint64_t number) {
  return number % TaskCount(config);
}

}  // namespace metronome::policy
