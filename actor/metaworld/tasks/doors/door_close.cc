#include "actor/metaworld/tasks/doors/door.h"
#include "actor/metaworld/tasks/doors/doors.h"

/// Push a door shut. As metaworld 3.1.1 has it: envs/sawyer_door_close_v3.py.
namespace metronome::metaworld::tasks::doors {
namespace {

class DoorClose final : public Door {
 public:
  DoorClose(const TaskSpec& task, const EnvironmentOptions& options)
      : Door(task, options, -1.5708, {0.2, -0.2, 0}) {}

 private:
  Outcome Evaluate(const Observation& observation, const Action& /*action*/) override {
    const Eigen::Vector3d handle = At3(observation.data() + 4, 0);
    const double to_target = Norm(handle - target_);
    const double in_place = Gaussian(to_target, 0.05, Norm(object_init_ - target_));
    // The hand is drawn to the goal, too; its margin moves with the handle, as official.
    const double hand_in_place =
        Gaussian(Norm(Tcp() - target_), 0.25 * 0.05, Norm(HandInit() - handle) + 0.1);
    return {to_target < 0.05 ? 10 : 3 * hand_in_place + 6 * in_place,
            {.success = to_target <= 0.08,
             .near_object = 0,
             .grasp_success = 1,
             .grasp_reward = 1,
             .in_place_reward = hand_in_place,
             .obj_to_target = to_target}};
  }
};

}  // namespace

TaskSpec DoorCloseTask() {
  return {.name = "door-close",
          .family = "doors",
          .scene = "sawyer_xyz/sawyer_door_pull.xml",
          .success = "the handle within 8 cm of its place in the shut door",
          .expert = {1.0, 1.0, 4455},
          .placement_size = 3,
          .low = {0, 0.85, 0.15},
          .high = {0.1, 0.95, 0.15},
          .goal_box = Box{{0.2, 0.65, 0.1499}, {0.3, 0.75, 0.1501}},
          .hand = {.initial = {-0.5F, 0.6F, 0.2F}},
          .view = {{0, 0.65, 0.14}, 1.1, 120, -30},
          .make = Make<DoorClose>};
}

}  // namespace metronome::metaworld::tasks::doors
