#pragma once

#include "actor/metaworld/task_spec.h"

/// A door with a handle, or with a lock: a task a file.
namespace metronome::metaworld::tasks::doors {

TaskSpec DoorCloseTask();
TaskSpec DoorLockTask();
TaskSpec DoorOpenTask();
TaskSpec DoorUnlockTask();

}  // namespace metronome::metaworld::tasks::doors
