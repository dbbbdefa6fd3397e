#include "actor/metaworld/tasks/windows/window.h"
#include "actor/metaworld/tasks/windows/windows.h"

/// Push a window shut. As metaworld 3.1.1 has it: envs/sawyer_window_close_v3.py.
namespace metronome::metaworld::tasks::windows {
namespace {

double Near(double distance, double margin) { return Gaussian(distance, kNearRadius, margin); }

constexpr WindowSettings kSettings = {
    .handle = "handleCloseStart", .start = 0.2, .from_handle = true, .near = Near};

}  // namespace

TaskSpec WindowCloseTask() {
  return {.name = "window-close",
          .family = "windows",
          .scene = "sawyer_xyz/sawyer_window_horizontal.xml",
          .success = "the handle within 5 cm of the goal from left to right",
          .expert = {1.0, 1.0, 3617},
          .placement_size = 3,
          .low = {0, 0.75, 0.2},
          .high = {0, 0.9, 0.2},
          .goal_box = HandBox(),
          .hand = {.initial = {0, 0.4F, 0.2F}},
          .view = {{0.05, 0.68, 0.17}, 0.95, 120, -20},
          .make = Make<Window, kSettings>};
}

}  // namespace metronome::metaworld::tasks::windows
