#include "actor/metaworld/tasks/pushing/pushed_object.h"
#include "actor/metaworld/tasks/pushing/pushing.h"

/// Push a puck around a wall to a goal. As metaworld 3.1.1 has it: envs/sawyer_push_wall_v3.py.
namespace metronome::metaworld::tasks::pushing {
namespace {

class PushWall final : public PushedObject {
 public:
  PushWall(const TaskSpec& task, const EnvironmentOptions& options)
      : PushedObject(task, options, {.success = 0.07}) {}

 private:
  [[nodiscard]] Reward RewardOf(const Moment& now, float gripper) const override {
    const double in_place = LongTail(now.to_target, 0, 0.05, Norm(object_init_ - target_));
    const Scalar grasp = Caging(now.object, kPuckCaging, gripper);
    Scalar reward = 2 * grasp;
    if (now.tcp_to_object < 0.02 && now.opening > 0)
      reward = now.object.y() > 0.75 ? reward + 1 + 4 + 3 * in_place  // past the wall
                                     : reward + 1 + 4 * BesideWall(now.object);
    if (now.to_target < kNear) reward = 10;
    return {reward, grasp, in_place};
  }

  /// How near the puck is to the wall's left end.
  [[nodiscard]] double BesideWall(const Eigen::Vector3d& object) const {
    const Eigen::Vector3d end(-0.05, 0.77, object.z()), scale(3, 1, 1);
    return LongTail(Norm((object - end).cwiseProduct(scale)), 0, 0.05,
                    Norm((object_init_ - end).cwiseProduct(scale)));
  }
};

}  // namespace

TaskSpec PushWallTask() {
  return {.name = "push-wall",
          .family = "pushing",
          .scene = "sawyer_xyz/sawyer_push_wall_v3.xml",
          .success = "the puck within 7 cm of the goal",
          .expert = {1.0, 0.1, 4356},
          .low = {-0.05, 0.6, 0.015, -0.05, 0.85, 0.01},
          .high = {0.05, 0.65, 0.015, 0.05, 0.9, 0.02},
          .min_planar_distance = 0.15,
          .hand = {.initial = {0, 0.6, 0.2}},
          .view = {{0.03, 0.74, 0.12}, 0.85, 130, -30},
          .make = Make<PushWall>};
}

}  // namespace metronome::metaworld::tasks::pushing
