#pragma once

#include "actor/metaworld/task_spec.h"

/// A box with a button to be pressed: a task a file.
namespace metronome::metaworld::tasks::buttons {

TaskSpec ButtonPressTask();
TaskSpec ButtonPressTopdownTask();
TaskSpec ButtonPressTopdownWallTask();
TaskSpec ButtonPressWallTask();

}  // namespace metronome::metaworld::tasks::buttons
