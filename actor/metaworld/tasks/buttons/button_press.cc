#include "actor/metaworld/tasks/buttons/button.h"
#include "actor/metaworld/tasks/buttons/buttons.h"

/// Press a button in a box's front. As metaworld 3.1.1 has it: envs/sawyer_button_press_v3.py.
namespace metronome::metaworld::tasks::buttons {
namespace {

constexpr ButtonSettings kSettings = {
    .axis = 1, .near_radius = 0.05, .success = 0.02, .reward = PressOpenHanded};

}  // namespace

TaskSpec ButtonPressTask() {
  return {.name = "button-press",
          .family = "buttons",
          .scene = "sawyer_xyz/sawyer_button_press.xml",
          .success = "the button within 2 cm of pressed in",
          .expert = {1.0, 1.0, 560},
          .placement_size = 3,
          .low = {-0.1, 0.85, 0.115},
          .high = {0.1, 0.9, 0.115},
          .goal_box = HandBox(),
          .hand = {.initial = {0, 0.4F, 0.2F}},
          .view = {{0.02, 0.68, 0.14}, 0.9, 140, -25},
          .make = Make<BoxButton, kSettings>};
}

}  // namespace metronome::metaworld::tasks::buttons
