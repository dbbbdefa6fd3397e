#pragma once

#include "actor/metaworld/task_spec.h"

/// A handle on a box to be pressed or pulled, and a lever: a task a file.
namespace metronome::metaworld::tasks::handles {

TaskSpec HandlePressTask();
TaskSpec HandlePressSideTask();
TaskSpec HandlePullTask();
TaskSpec HandlePullSideTask();
TaskSpec LeverPullTask();

}  // namespace metronome::metaworld::tasks::handles
