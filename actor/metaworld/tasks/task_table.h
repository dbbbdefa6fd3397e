#pragma once

#include <memory>
#include <string>
#include <vector>

#include "actor/metaworld/sawyer.h"
#include "actor/metaworld/task_spec.h"

namespace metronome::metaworld::tasks {

/// The table, in alphabetical order. Thread-safe.
const std::vector<TaskSpec>& AllTasks();

/// @param spelling  NAME, NAME-v2 or NAME-v3.
/// @throws std::invalid_argument for any other, naming the near miss and the list.
const TaskSpec& FindTask(const std::string& spelling);

/// @param task  any accepted spelling.
/// @throws std::invalid_argument for an unknown task (names the near miss and the list),
///         std::runtime_error when scene files are missing (says to run deploy/setup).
std::unique_ptr<SawyerEnvironment> MakeSawyerEnvironment(const std::string& task,
                                                         const EnvironmentOptions& options);

}  // namespace metronome::metaworld::tasks
