#include <cmath>

#include "actor/metaworld/tasks/drawers/drawer.h"
#include "actor/metaworld/tasks/drawers/drawers.h"

/// Push a drawer shut. As metaworld 3.1.1 has it: envs/sawyer_drawer_close_v3.py.
namespace metronome::metaworld::tasks::drawers {
namespace {

constexpr double kOpen = -0.15;  // of the slide, metres

class DrawerClose final : public Drawer {
 public:
  DrawerClose(const TaskSpec& task, const EnvironmentOptions& options)
      : Drawer(task, options, {0, -0.16, 0.05}) {}

 private:
  void PlaceObject(const RandVec& p) override {
    target_ = ObjectOf(p) + Eigen::Vector3d(0, -0.16, 0.09);
    MoveSite(goal_, target_);
    SetQpos(slide_, {kOpen});  // and keeps its velocity
    Forward();
    object_init_ = Handle();
  }

  [[nodiscard]] ObjectPose Object() const override { return {.position = Handle()}; }

  Outcome Evaluate(const Observation& observation, const Action& action) override {
    const Eigen::Vector3d handle = At3(observation.data() + 4, 0);
    const double tcp_to_handle = Norm(handle - Tcp());
    const double to_target = Norm(handle - target_);
    const double in_place =
        LongTail(to_target, 0, 0.05, std::abs(Norm(object_init_ - target_) - 0.05));
    const double near =
        Gaussian(tcp_to_handle, 0.005, std::abs(Norm(object_init_ - tcp_init_) - 0.005));
    const Scalar reach = Hamacher(near, ClosedExtent(action[3], 1));
    const bool success = to_target <= 0.05 + 0.015;
    const Scalar reward = success ? 1 : Hamacher(reach, in_place);
    return {(reward * 10).value(),
            {.success = success,
             .near_object = tcp_to_handle <= 0.01 ? 1.0 : 0.0,
             .grasp_success = 1,
             .grasp_reward = reach.value(),
             .in_place_reward = in_place,
             .obj_to_target = to_target}};
  }
};

}  // namespace

TaskSpec DrawerCloseTask() {
  return {.name = "drawer-close",
          .family = "drawers",
          .scene = "sawyer_xyz/sawyer_drawer.xml",
          .success = "the handle within 6.5 cm of its place in the shut drawer",
          .expert = {1.0, 1.0, 4239},
          .placement_size = 3,
          .low = {-0.1, 0.9, 0},
          .high = {0.1, 0.9, 0},
          .goal_box = HandBox(),
          .hand = {.initial = {0, 0.6F, 0.2F}},
          .view = {{0.02, 0.68, 0.12}, 0.95, 140, -25},
          .make = Make<DrawerClose>};
}

}  // namespace metronome::metaworld::tasks::drawers
