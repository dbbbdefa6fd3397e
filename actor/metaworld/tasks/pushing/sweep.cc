#include "actor/metaworld/tasks/pushing/pushing.h"
#include "actor/metaworld/tasks/pushing/swept_object.h"

/// Sweep a block to the right, off the table. As metaworld 3.1.1 has it: envs/sawyer_sweep_v3.py.
namespace metronome::metaworld::tasks::pushing {
namespace {

class Sweep final : public SweptObject {
 public:
  Sweep(const TaskSpec& task, const EnvironmentOptions& options)
      : SweptObject(task, options, {.height = 0.02, .success = 0.05, .lifts = false},
                    {.object_radius = 0.02, .xz_threshold = 0.005}, 0.01) {}

 private:
  [[nodiscard]] Eigen::Vector3d Goal(const RandVec& p, double /*height*/) const override {
    return {0.5, p[1], 0.01};
  }
  [[nodiscard]] ObjectPose Object() const override {
    return {BodyPosition(Pushed()), BodyQuaternion(Pushed())};
  }
};

}  // namespace

TaskSpec SweepTask() {
  return {.name = "sweep",
          .family = "pushing",
          .scene = "sawyer_xyz/sawyer_sweep_v3.xml",
          .success = "the block within 5 cm of the goal at the table's right edge",
          .expert = {1.0, 1.0, 4404},
          .placement_size = 3,
          .low = {-0.1, 0.6, 0.02},
          .high = {0.1, 0.7, 0.02},
          .goal_box = Box{{0.49, 0.6, 0}, {0.51, 0.7, 0.02}},
          .hand = {.initial = {0, 0.6, 0.2}},
          .view = {{0.2, 0.65, 0.1}, 1.1, 110, -25},
          .make = Make<Sweep>};
}

}  // namespace metronome::metaworld::tasks::pushing
