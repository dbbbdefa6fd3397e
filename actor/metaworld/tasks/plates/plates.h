#pragma once

#include "actor/metaworld/task_spec.h"

/// A plate that slides on the table, and a goal's frame: a task a file.
namespace metronome::metaworld::tasks::plates {

TaskSpec PlateSlideTask();
TaskSpec PlateSlideBackTask();
TaskSpec PlateSlideBackSideTask();
TaskSpec PlateSlideSideTask();

}  // namespace metronome::metaworld::tasks::plates
