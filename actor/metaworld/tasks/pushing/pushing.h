#pragma once

#include "actor/metaworld/task_spec.h"

/// A free object to be pushed: a task a file.
namespace metronome::metaworld::tasks::pushing {

TaskSpec PushTask();
TaskSpec PushBackTask();
TaskSpec PushWallTask();
TaskSpec SoccerTask();
TaskSpec SweepTask();
TaskSpec SweepIntoTask();

}  // namespace metronome::metaworld::tasks::pushing
