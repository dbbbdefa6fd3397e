#pragma once

#include <optional>
#include <ostream>
#include <string>

#include "actor/metaworld/sawyer.h"
#include "actor/replay/recording.h"

namespace metronome::replay {

enum class TraceMode {
  kForced,  // observe and reward the recorded states
  kFree,    // start at the recorded placement, then only the recorded actions
};

struct TraceOptions {
  std::string task;       // any accepted spelling
  std::string recording;  // .csv or .csv.gz
  std::string mode;       // "forced" | "free"
  std::string assets;     // folder of the scene files; empty: the default
};

/// The reset's observation and what every step returned; nothing where it is forced and the
/// recording has no state.
struct Trace {
  metaworld::Observation reset{};
  std::vector<std::optional<metaworld::StepResult>> steps;
};

/// Plays `recording` on a fresh environment of its task.
/// @throws std::invalid_argument if the recording does not fit the scene.
Trace PlayRecording(const Recording& recording, TraceMode mode, const std::string& assets);

/// `metronome-actor trace`: prints the environment's own numbers for a recorded episode. CSV with
/// the header step,obs0..obs38,reward,success,near_object,grasp_success,grasp_reward,
/// in_place_reward,obj_to_target; row 0 is the reset (reward and info empty), then a row a step
/// (forced: of those whose state is recorded).
/// Numbers read back as the same doubles.
/// @return exit status: 0; 2 for bad options or a bad recording, 1 where the scene cannot be
/// loaded;
///         then nothing is written to `out` and the reason to stderr.
int RunTrace(const TraceOptions& options, std::ostream& out);

}  // namespace metronome::replay
