#include "actor/metaworld/tasks/buttons/button.h"
#include "actor/metaworld/tasks/buttons/buttons.h"

/// Press a button in a box's front, past a wall. As metaworld 3.1.1 has it:
/// envs/sawyer_button_press_wall_v3.py.
namespace metronome::metaworld::tasks::buttons {
namespace {

/// Come with a closed gripper, then press with an open one.
double CloseThenOpen(const Press& press) {
  if (press.tcp_to_button > 0.07) return 2 * Hamacher((1 - press.opening) / 2, press.near).value();
  return 2 + 2 * (1 + press.opening) + 4 * (press.pressed * press.pressed);
}

constexpr ButtonSettings kSettings = {
    .axis = 1, .near_radius = 0.01, .success = 0.03, .reward = CloseThenOpen};

}  // namespace

TaskSpec ButtonPressWallTask() {
  return {.name = "button-press-wall",
          .family = "buttons",
          .scene = "sawyer_xyz/sawyer_button_press_wall.xml",
          .success = "the button within 3 cm of pressed in",
          .expert = {0.9, 0.9, 4022},
          .placement_size = 3,
          .low = {-0.05, 0.85, 0.1149},
          .high = {0.05, 0.9, 0.1151},
          .goal_box = HandBox(),
          .hand = {.initial = {0, 0.4F, 0.2F}},
          .view = {{0.02, 0.68, 0.14}, 0.9, 140, -25},
          .make = Make<BoxButton, kSettings>};
}

}  // namespace metronome::metaworld::tasks::buttons
