#pragma once

#include "actor/metaworld/task_spec.h"

/// A free object to be picked up, and the hand alone: a task a file.
namespace metronome::metaworld::tasks::pick_place {

TaskSpec BasketballTask();
TaskSpec BinPickingTask();
TaskSpec BoxCloseTask();
TaskSpec HandInsertTask();
TaskSpec PegInsertSideTask();
TaskSpec PegUnplugSideTask();
TaskSpec PickOutOfHoleTask();
TaskSpec PickPlaceTask();
TaskSpec PickPlaceWallTask();
TaskSpec ReachTask();
TaskSpec ReachWallTask();
TaskSpec ShelfPlaceTask();

}  // namespace metronome::metaworld::tasks::pick_place
