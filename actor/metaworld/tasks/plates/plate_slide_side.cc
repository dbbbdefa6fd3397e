#include "actor/metaworld/tasks/plates/plate.h"
#include "actor/metaworld/tasks/plates/plates.h"

/// Slide a plate to the left. The goal's frame stays where the scene has it, whatever the goal: as
/// official. As metaworld 3.1.1 has it: envs/sawyer_plate_slide_side_v3.py.
namespace metronome::metaworld::tasks::plates {
namespace {

class PlateSlideSide final : public Plate {
 public:
  PlateSlideSide(const TaskSpec& task, const EnvironmentOptions& options)
      : Plate(task, options, {.x = 0, .y = 0, .slack = 0.05}) {}
};

}  // namespace

TaskSpec PlateSlideSideTask() {
  return {.name = "plate-slide-side",
          .family = "plates",
          .scene = "sawyer_xyz/sawyer_plate_slide_sideway.xml",
          .success = "the plate within 7 cm of the goal",
          .expert = {1.0, 0.0, 2883},
          .low = {0, 0.6, 0, -0.3, 0.54, 0},
          .high = {0, 0.6, 0, -0.25, 0.66, 0},
          .hand = {.initial = {0, 0.6F, 0.2F}},
          .view = {{-0.08, 0.64, 0.1}, 0.85, 120, -30},
          .make = Make<PlateSlideSide>};
}

}  // namespace metronome::metaworld::tasks::plates
