#pragma once

#include "actor/metaworld/task_spec.h"

/// A drawer with a handle: a task a file.
namespace metronome::metaworld::tasks::drawers {

TaskSpec DrawerCloseTask();
TaskSpec DrawerOpenTask();

}  // namespace metronome::metaworld::tasks::drawers
