#include "actor/metaworld/tasks/handles/handle.h"
#include "actor/metaworld/tasks/handles/handles.h"

/// Press a handle down. As metaworld 3.1.1 has it: envs/sawyer_handle_press_v3.py.
namespace metronome::metaworld::tasks::handles {

TaskSpec HandlePressTask() {
  return {.name = "handle-press",
          .family = "handles",
          .scene = "sawyer_xyz/sawyer_handle_press.xml",
          .success = "the handle within 2 cm of the height of the goal",
          .expert = {1.0, 0.0, 1296},
          .placement_size = 3,
          .low = {-0.1, 0.8, -0.001},
          .high = {0.1, 0.9, 0.001},
          .goal_box = Box{{-0.1, 0.55, 0.04}, {0.1, 0.7, 0.08}},
          .hand = {.initial = {0, 0.6, 0.2}, .settles_alike = false},
          .view = {{0.02, 0.68, 0.16}, 0.8, 140, -20},
          .make = Make<HandlePress>};
}

}  // namespace metronome::metaworld::tasks::handles
