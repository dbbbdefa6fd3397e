#pragma once

#include "actor/metaworld/task_spec.h"

/// A window that slides sideways: a task a file.
namespace metronome::metaworld::tasks::windows {

TaskSpec WindowCloseTask();
TaskSpec WindowOpenTask();

}  // namespace metronome::metaworld::tasks::windows
