#include "actor/metaworld/tasks/buttons/button.h"
#include "actor/metaworld/tasks/buttons/buttons.h"

/// Press a button in a box's lid. As metaworld 3.1.1 has it:
/// envs/sawyer_button_press_topdown_v3.py.
namespace metronome::metaworld::tasks::buttons {
namespace {

double PressWithFist(const Press& press) { return PressFromAbove(1 - press.opening, press); }

constexpr ButtonSettings kSettings = {
    .axis = 2, .near_radius = 0.01, .success = 0.024, .reward = PressWithFist};

}  // namespace

TaskSpec ButtonPressTopdownTask() {
  return {.name = "button-press-topdown",
          .family = "buttons",
          .scene = "sawyer_xyz/sawyer_button_press_topdown.xml",
          .success = "the button within 2.4 cm of pressed down",
          .expert = {1.0, 1.0, 3808},
          .placement_size = 3,
          .low = {-0.1, 0.8, 0.115},
          .high = {0.1, 0.9, 0.115},
          .goal_box = HandBox(),
          .hand = {.initial = {0, 0.4F, 0.2F}},
          .view = {{0.02, 0.68, 0.14}, 0.9, 140, -25},
          .make = Make<BoxButton, kSettings>};
}

}  // namespace metronome::metaworld::tasks::buttons
