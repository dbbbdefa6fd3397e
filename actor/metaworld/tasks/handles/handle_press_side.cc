#include "actor/metaworld/tasks/handles/handle.h"
#include "actor/metaworld/tasks/handles/handles.h"

/// Press down a handle that points to the right. As metaworld 3.1.1 has it:
/// envs/sawyer_handle_press_side_v3.py.
namespace metronome::metaworld::tasks::handles {

TaskSpec HandlePressSideTask() {
  return {.name = "handle-press-side",
          .family = "handles",
          .scene = "sawyer_xyz/sawyer_handle_press_sideways.xml",
          .success = "the handle within 2 cm of the height of the goal",
          .expert = {1.0, 0.0, 1112},
          .placement_size = 3,
          .low = {-0.35, 0.65, -0.001},
          .high = {-0.25, 0.75, 0.001},
          .goal_box = Box{{-0.5, 0.4, 0.05}, {0.5, 1, 0.5}},
          .hand = {.initial = {0, 0.6, 0.2}, .settles_alike = false},
          .view = {{-0.1, 0.68, 0.14}, 0.85, 135, -20},
          .make = Make<HandlePress>};
}

}  // namespace metronome::metaworld::tasks::handles
