#include "actor/metaworld/tasks/plates/plate.h"
#include "actor/metaworld/tasks/plates/plates.h"

/// Slide a plate away from the robot into the goal. As metaworld 3.1.1 has it:
/// envs/sawyer_plate_slide_v3.py.
namespace metronome::metaworld::tasks::plates {
namespace {

class PlateSlide final : public Plate {
 public:
  PlateSlide(const TaskSpec& task, const EnvironmentOptions& options)
      : Plate(task, options, {.x = 0, .y = 0, .slack = 0}) {}

 private:
  void EditModel(const RandVec& p) override { MoveBody(GoalFrame(), GoalOf(p)); }

  [[nodiscard]] double Reward(double /*tcp_to_plate*/, double grasp,
                              double in_place) const override {
    return 8 * Hamacher(grasp, in_place).value();
  }
};

}  // namespace

TaskSpec PlateSlideTask() {
  return {.name = "plate-slide",
          .family = "plates",
          .scene = "sawyer_xyz/sawyer_plate_slide.xml",
          .success = "the plate within 7 cm of the goal",
          .expert = {1.0, 0.8, 4567},
          .low = {0, 0.6, 0, -0.1, 0.85, 0},
          .high = {0, 0.6, 0, 0.1, 0.9, 0},
          .hand = {.initial = {0, 0.6F, 0.2F}},
          .view = {{0.03, 0.72, 0.1}, 0.85, 140, -25},
          .make = Make<PlateSlide>};
}

}  // namespace metronome::metaworld::tasks::plates
