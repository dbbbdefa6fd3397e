#include "actor/metaworld/tasks/drawers/drawer.h"
#include "actor/metaworld/tasks/drawers/drawers.h"

/// Pull a drawer open. As metaworld 3.1.1 has it: envs/sawyer_drawer_open_v3.py.
namespace metronome::metaworld::tasks::drawers {
namespace {

constexpr double kTravel = 0.2;  // of the handle, metres

/// Length of a way on which height counts a third.
double FlatNorm(const Eigen::Vector3d& way) {
  return Norm(Eigen::Vector3d(3 * way.x(), 3 * way.y(), way.z()));
}

class DrawerOpen final : public Drawer {
 public:
  DrawerOpen(const TaskSpec& task, const EnvironmentOptions& options)
      : Drawer(task, options, {0, -0.16, 0}) {}

 private:
  void PlaceObject(const RandVec& p) override {
    object_init_ = ObjectOf(p);
    target_ = object_init_ + Eigen::Vector3d(0, -0.16 - kTravel, 0.09);
    MoveSite(goal_, target_);
  }

  [[nodiscard]] ObjectPose Object() const override { return {Handle(), BodyQuaternion(drawer_)}; }

  Outcome Evaluate(const Observation& observation, const Action& /*action*/) override {
    const Eigen::Vector3d hand = At3(observation.data(), 0);
    const Eigen::Vector3d handle = At3(observation.data() + 4, 0);
    const Eigen::Vector3d shut = target_ + Eigen::Vector3d(0, kTravel, 0);
    const double to_target = Norm(handle - target_);
    const double opened = LongTail(to_target, 0, 0.02, kTravel);
    const double near = LongTail(FlatNorm(handle - hand), 0, 0.01, FlatNorm(shut - tcp_init_));
    return {5 * (near + opened),
            {.success = to_target <= 0.03,
             .near_object = Norm(handle - hand) <= 0.03 ? 1.0 : 0.0,
             .grasp_success = observation[3] > 0 ? 1.0 : 0.0,
             .grasp_reward = near,
             .in_place_reward = opened,
             .obj_to_target = to_target}};
  }
};

}  // namespace

TaskSpec DrawerOpenTask() {
  return {.name = "drawer-open",
          .family = "drawers",
          .scene = "sawyer_xyz/sawyer_drawer.xml",
          .success = "the handle within 3 cm of the goal, 20 cm before the shut drawer",
          .expert = {1.0, 1.0, 4023},
          .placement_size = 3,
          .low = {-0.1, 0.9, 0},
          .high = {0.1, 0.9, 0},
          .goal_box = HandBox(),
          .hand = {.initial = {0, 0.6F, 0.2F}},
          .view = {{0.02, 0.68, 0.12}, 0.95, 140, -25},
          .make = Make<DrawerOpen>};
}

}  // namespace metronome::metaworld::tasks::drawers
