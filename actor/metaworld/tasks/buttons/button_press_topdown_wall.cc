#include "actor/metaworld/tasks/buttons/button.h"
#include "actor/metaworld/tasks/buttons/buttons.h"

/// Press a button in a box's lid, past a wall. As metaworld 3.1.1 has it:
/// envs/sawyer_button_press_topdown_wall_v3.py.
namespace metronome::metaworld::tasks::buttons {
namespace {

/// An open gripper is rewarded, unlike in the task without a wall.
double PressFromAboveOpenHanded(const Press& press) { return PressFromAbove(press.opening, press); }

constexpr ButtonSettings kSettings = {
    .axis = 2, .near_radius = 0.01, .success = 0.024, .reward = PressFromAboveOpenHanded};

}  // namespace

TaskSpec ButtonPressTopdownWallTask() {
  return {.name = "button-press-topdown-wall",
          .family = "buttons",
          .scene = "sawyer_xyz/sawyer_button_press_topdown_wall.xml",
          .success = "the button within 2.4 cm of pressed down",
          .expert = {1.0, 1.0, 2103},
          .placement_size = 3,
          .low = {-0.1, 0.8, 0.115},
          .high = {0.1, 0.9, 0.115},
          .goal_box = HandBox(),
          .hand = {.initial = {0, 0.4F, 0.2F}},
          .view = {{0.02, 0.68, 0.14}, 0.9, 140, -25},
          .make = Make<BoxButton, kSettings>};
}

}  // namespace metronome::metaworld::tasks::buttons
