#include "actor/metaworld/tasks/plates/plate.h"
#include "actor/metaworld/tasks/plates/plates.h"

/// Pull a plate out of the goal's frame towards the robot. As metaworld 3.1.1 has it:
/// envs/sawyer_plate_slide_back_v3.py.
namespace metronome::metaworld::tasks::plates {
namespace {

class PlateSlideBack final : public Plate {
 public:
  PlateSlideBack(const TaskSpec& task, const EnvironmentOptions& options)
      : Plate(task, options, {.x = 0, .y = 0.15, .slack = 0.05}) {}
};

}  // namespace

TaskSpec PlateSlideBackTask() {
  return {.name = "plate-slide-back",
          .family = "plates",
          .scene = "sawyer_xyz/sawyer_plate_slide.xml",
          .success = "the plate within 7 cm of the goal",
          .expert = {1.0, 0.0, 1177},
          .low = {0, 0.85, 0, -0.1, 0.6, 0.015},
          .high = {0, 0.85, 0, 0.1, 0.6, 0.015},
          .hand = {.initial = {0, 0.6F, 0.2F}},
          .view = {{0.03, 0.72, 0.1}, 0.85, 140, -25},
          .make = Make<PlateSlideBack>};
}

}  // namespace metronome::metaworld::tasks::plates
