#pragma once

#include "actor/metaworld/task_spec.h"

/// A ring with a handle, and a peg: a task a file.
namespace metronome::metaworld::tasks::nuts {

TaskSpec AssemblyTask();
TaskSpec DisassembleTask();

}  // namespace metronome::metaworld::tasks::nuts
