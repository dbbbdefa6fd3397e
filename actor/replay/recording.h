#pragma once

#include <optional>
#include <string>
#include <vector>

#include "actor/metaworld/sawyer.h"

namespace metronome::replay {

/// One step of a recorded episode: the action, and where the file tells the physical state after it
/// and what step() gave.
struct RecordedStep {
  metaworld::Action action{};
  std::optional<metaworld::RecordedState> state;
  std::optional<metaworld::StepResult> returned;
};

/// An episode of the official environment, as its recorder writes it: a `# ` line of JSON, a line
/// of column names, a row per step; plain or gzip. Rows may leave all empty but step and action.
struct Recording {
  std::string task;  // as recorded, e.g. "push-v3"
  metaworld::RandVec placement{};
  metaworld::RecordedStart start;
  std::vector<RecordedStep> steps;  // 1 to 500
};

/// @throws std::invalid_argument naming the file and what is wrong with it: missing, cut short, a
///         key or column missing, a number that is none.
Recording ReadRecording(const std::string& path);

}  // namespace metronome::replay
