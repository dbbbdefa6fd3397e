#include <algorithm>
#include <cmath>
#include <numbers>

#include "actor/metaworld/funnel.h"
#include "actor/metaworld/tasks/doors/door.h"
#include "actor/metaworld/tasks/doors/doors.h"

/// Pull a door open by its handle. As metaworld 3.1.1 has it: envs/sawyer_door_v3.py.
namespace metronome::metaworld::tasks::doors {
namespace {

using std::numbers::pi;

constexpr Funnel kAroundHandle = {.radius = 0.12, .slope = 0.04, .height = 0.4};

double RewardReady(const Eigen::Vector3d& hand, const Eigen::Vector3d& handle) {
  const double floor = FunnelHeight(kAroundHandle, Norm((hand - handle).head<2>()));
  const Eigen::Vector3d grip(0.05, 0.03, -0.01);  // of the hand on the handle
  return Hamacher(AboveFloor(hand.z(), floor, floor / 2),
                  LongTail(Norm(hand - handle - grip), 0, 0.06, 0.5))
      .value();
}

/// @param angle  radians, negative when open.
double RewardOpen(double angle) {
  return 0.2 * (angle < -pi / 90 ? 1 : 0) + 0.8 * LongTail(2 * pi / 3 + angle, 0, 0.5, pi / 3);
}

class DoorOpen final : public Door {
 public:
  DoorOpen(const TaskSpec& task, const EnvironmentOptions& options)
      : Door(task, options, 0, {-0.3, -0.45, 0}) {}

 private:
  Outcome Evaluate(const Observation& observation, const Action& action) override {
    const Eigen::Vector3d hand = At3(observation.data(), 0);
    const Eigen::Vector3d object = At3(observation.data() + 4, 0);
    const Eigen::Vector3d handle = object + Eigen::Vector3d(-0.05, 0, 0);
    const double grab = (std::clamp(action[3], -1.0F, 1.0F) + 1.0F) / 2.0F;
    const double ready = RewardReady(hand, handle);
    const double opened = RewardOpen(Angle());
    const bool success = std::abs(object.x() - target_.x()) <= 0.08;
    return {success ? 10 : 2 * Hamacher(ready, grab).value() + 8 * opened,
            {.success = success,
             .near_object = ready,
             .grasp_success = grab >= 0.5 ? 1.0 : 0.0,
             .grasp_reward = grab,
             .in_place_reward = opened,
             .obj_to_target = 0}};
  }
};

}  // namespace

TaskSpec DoorOpenTask() {
  return {.name = "door-open",
          .family = "doors",
          .scene = "sawyer_xyz/sawyer_door_pull.xml",
          .success = "the handle within 8 cm of the goal from left to right",
          .expert = {0.9, 0.0, 4227},
          .placement_size = 3,
          .low = {0, 0.85, 0.15},
          .high = {0.1, 0.95, 0.15},
          .goal_box = Box{{-0.3, 0.4, 0.1499}, {-0.2, 0.5, 0.1501}},
          .hand = {.initial = {0, 0.6, 0.2}},
          .view = {{0, 0.65, 0.14}, 1.1, 120, -30},
          .make = Make<DoorOpen>};
}

}  // namespace metronome::metaworld::tasks::doors
