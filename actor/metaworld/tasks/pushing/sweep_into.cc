#include "actor/metaworld/tasks/pushing/pushing.h"
#include "actor/metaworld/tasks/pushing/swept_object.h"

/// Sweep a block into a hole of the table. As metaworld 3.1.1 has it:
/// envs/sawyer_sweep_into_goal_v3.py.
namespace metronome::metaworld::tasks::pushing {
namespace {

class SweepInto final : public SweptObject {
 public:
  SweepInto(const TaskSpec& task, const EnvironmentOptions& options)
      : SweptObject(task, options, {.success = 0.05, .lifts = false},
                    {.object_radius = 0.02, .xz_threshold = 0.01}, 0.005) {}

 private:
  [[nodiscard]] Eigen::Vector3d Goal(const RandVec& /*p*/, double /*height*/) const override {
    return {0, 0.84, 0.02};  // the placement's goal part is drawn but not used
  }
  /// Heights do not count.
  [[nodiscard]] Eigen::Vector3d GoalFor(const Eigen::Vector3d& object) const override {
    return {target_.x(), target_.y(), object.z()};
  }
};

}  // namespace

TaskSpec SweepIntoTask() {
  return {.name = "sweep-into",
          .family = "pushing",
          .scene = "sawyer_xyz/sawyer_table_with_hole.xml",
          .success = "the block within 5 cm of the hole's centre, seen from above",
          .expert = {0.9, 0.3, 2049},
          .low = {-0.1, 0.6, 0.02, -0.001, 0.8399, 0.0199},
          .high = {0.1, 0.7, 0.02, 0.001, 0.8401, 0.0201},
          .min_planar_distance = 0.15,
          .keep_from = Eigen::Vector2d(0, 0.84),
          .hand = {.initial = {0, 0.6, 0.2}},
          .view = {{0.03, 0.72, 0.14}, 0.85, 140, -25},
          .make = Make<SweepInto>};
}

}  // namespace metronome::metaworld::tasks::pushing
