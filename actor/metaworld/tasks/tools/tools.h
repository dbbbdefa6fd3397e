#pragma once

#include "actor/metaworld/task_spec.h"

/// A tool in the hand that moves a second object: a task a file.
namespace metronome::metaworld::tasks::tools {

TaskSpec HammerTask();
TaskSpec StickPullTask();
TaskSpec StickPushTask();

}  // namespace metronome::metaworld::tasks::tools
