#include "actor/metaworld/tasks/plates/plate.h"
#include "actor/metaworld/tasks/plates/plates.h"

/// Slide a plate to the right, out of the goal's frame. As metaworld 3.1.1 has it:
/// envs/sawyer_plate_slide_back_side_v3.py.
namespace metronome::metaworld::tasks::plates {
namespace {

class PlateSlideBackSide final : public Plate {
 public:
  PlateSlideBackSide(const TaskSpec& task, const EnvironmentOptions& options)
      : Plate(task, options, {.x = -0.15, .y = 0, .slack = 0.05}) {}

 private:
  void EditModel(const RandVec& p) override { MoveBody(GoalFrame(), ObjectOf(p)); }
};

}  // namespace

TaskSpec PlateSlideBackSideTask() {
  return {.name = "plate-slide-back-side",
          .family = "plates",
          .scene = "sawyer_xyz/sawyer_plate_slide_sideway.xml",
          .success = "the plate within 7 cm of the goal",
          .expert = {1.0, 0.0, 987},
          .low = {-0.25, 0.6, 0, -0.05, 0.6, 0.015},
          .high = {-0.25, 0.6, 0, 0.15, 0.6, 0.015},
          .hand = {.initial = {0, 0.6F, 0.2F}},
          .view = {{-0.08, 0.64, 0.1}, 0.85, 120, -30},
          .make = Make<PlateSlideBackSide>};
}

}  // namespace metronome::metaworld::tasks::plates
