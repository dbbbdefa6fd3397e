#pragma once

#include <functional>

namespace metronome::learner {

/// Calls `start`, which checks what was asked for, and serves it through CodeOfServing; logs what
/// it throws.
/// @return its ExitCode, or that of the exception: process::kExitRival for a run that is held,
/// process::kExitUsage for what another try of the same would meet again, process::kExitFailure for
/// the rest.
int CodeOfStart(const std::function<int()>& start);

/// Calls `serve`; logs what it throws. Services do not start again what ends with
/// process::kExitUsage, so that never comes of it: what is thrown once a run is served is not for
/// what was asked.
/// @return its ExitCode, or process::kExitFailure.
int CodeOfServing(const std::function<int()>& serve);

}  // namespace metronome::learner
