#pragma once

#include "actor/metaworld/task_spec.h"

/// A coffee machine and a mug: a task a file.
namespace metronome::metaworld::tasks::coffee {

TaskSpec CoffeeButtonTask();
TaskSpec CoffeePullTask();
TaskSpec CoffeePushTask();

}  // namespace metronome::metaworld::tasks::coffee
