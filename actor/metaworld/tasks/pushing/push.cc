#include "actor/metaworld/tasks/pushing/pushed_object.h"
#include "actor/metaworld/tasks/pushing/pushing.h"

/// Push a puck to a goal on the table. As metaworld 3.1.1 has it: envs/sawyer_push_v3.py.
namespace metronome::metaworld::tasks::pushing {
namespace {

class Push final : public PushedObject {
 public:
  Push(const TaskSpec& task, const EnvironmentOptions& options)
      : PushedObject(task, options, {.success = 0.05}) {}

 private:
  [[nodiscard]] Reward RewardOf(const Moment& now, float gripper) const override {
    const double in_place = LongTail(now.to_target, 0, 0.05, Norm(object_init_ - target_));
    const Scalar grasp = Caging(now.object, kPuckCaging, gripper);
    Scalar reward = 2 * grasp;
    if (now.tcp_to_object < 0.02 && now.opening > 0) reward = reward + (1 + reward + 5 * in_place);
    if (now.to_target < kNear) reward = 10;
    return {reward, grasp, in_place};
  }
};

}  // namespace

TaskSpec PushTask() {
  return {.name = "push",
          .family = "pushing",
          .scene = "sawyer_xyz/sawyer_push_v3.xml",
          .success = "the puck within 5 cm of the goal",
          .expert = {1.0, 0.4, 4136},
          .low = {-0.1, 0.6, 0.02, -0.1, 0.8, 0.01},
          .high = {0.1, 0.7, 0.02, 0.1, 0.9, 0.02},
          .min_planar_distance = 0.15,
          .hand = {.initial = {0, 0.6, 0.2}},
          .view = {{0.03, 0.72, 0.14}, 0.75, 140, -20},
          .make = Make<Push>};
}

}  // namespace metronome::metaworld::tasks::pushing
