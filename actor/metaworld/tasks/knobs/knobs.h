#pragma once

#include "actor/metaworld/task_spec.h"

/// A dial or a faucet to be turned: a task a file.
namespace metronome::metaworld::tasks::knobs {

TaskSpec DialTurnTask();
TaskSpec FaucetCloseTask();
TaskSpec FaucetOpenTask();

}  // namespace metronome::metaworld::tasks::knobs
