#include "actor/metaworld/tasks/pushing/pushed_object.h"
#include "actor/metaworld/tasks/pushing/pushing.h"

/// Pull a block back towards the robot. As metaworld 3.1.1 has it: envs/sawyer_push_back_v3.py.
namespace metronome::metaworld::tasks::pushing {
namespace {

class PushBack final : public PushedObject {
 public:
  PushBack(const TaskSpec& task, const EnvironmentOptions& options)
      : PushedObject(task, options, {.success = 0.07}) {}

 private:
  [[nodiscard]] Reward RewardOf(const Moment& now, float /*gripper*/) const override {
    const double first = Norm(object_init_ - target_);
    const double in_place = LongTail(now.to_target, 0, 0.05, first);
    const double grasp =
        SignedGrasp(CagingAt(now.object), {.object_radius = 0.007, .xz_threshold = 0.01}, 0.003);
    const bool moved = first - now.to_target > 0.01;
    const bool held = now.tcp_to_object < 0.01 && 0 < now.opening && now.opening < 0.55;
    Scalar reward = Hamacher(grasp, in_place);
    if (held && moved) reward = reward + (1 + 5 * in_place);
    if (now.to_target < kNear) reward = 10;
    return {reward, grasp, in_place};
  }
};

}  // namespace

TaskSpec PushBackTask() {
  return {.name = "push-back",
          .family = "pushing",
          .scene = "sawyer_xyz/sawyer_push_back_v3.xml",
          .success = "the block within 7 cm of the goal",
          .expert = {0.9, 0.0, 363},
          .low = {-0.1, 0.8, 0.02, -0.1, 0.6, 0.0199},
          .high = {0.1, 0.85, 0.02, 0.1, 0.7, 0.0201},
          .min_planar_distance = 0.15,
          .hand = {.initial = {0, 0.6F, 0.2F}},
          .view = {{0.03, 0.72, 0.14}, 0.75, 140, -20},
          .make = Make<PushBack>};
}

}  // namespace metronome::metaworld::tasks::pushing
