#include "actor/metaworld/tasks/handles/handle.h"
#include "actor/metaworld/tasks/handles/handles.h"

/// Pull up a handle that points to the right. As metaworld 3.1.1 has it:
/// envs/sawyer_handle_pull_side_v3.py.
namespace metronome::metaworld::tasks::handles {
namespace {

constexpr CagingShape kCaging = {.object_radius = 0.032, .pad_success = 0.06, .xz_threshold = 0.01};

class HandlePullSide final : public HandlePull {
 public:
  HandlePullSide(const TaskSpec& task, const EnvironmentOptions& options)
      : HandlePull(task, options, "handleCenter", kCaging, 0.08) {}

 private:
  void PlaceObject(const RandVec& placement) override {
    Handle::PlaceObject(placement);
    object_init_ = HandlePosition();
  }
  [[nodiscard]] double ToTarget(const Eigen::Vector3d& place) const override {
    return Norm(place - target_);
  }
  [[nodiscard]] bool Moved(const Eigen::Vector3d& place) const override {
    return place.z() - 0.01 > object_init_.z();
  }
};

}  // namespace

TaskSpec HandlePullSideTask() {
  return {.name = "handle-pull-side",
          .family = "handles",
          .scene = "sawyer_xyz/sawyer_handle_press_sideways.xml",
          .success = "the handle's middle within 8 cm of the goal",
          .expert = {1.0, 0.1, 3157},
          .placement_size = 3,
          .low = {-0.35, 0.65, 0},
          .high = {-0.25, 0.75, 0},
          .goal_box = Box{{-0.5, 0.4, 0.05}, {0.5, 1, 0.5}},
          .hand = {.initial = {0, 0.6, 0.2}, .settles_alike = false},
          .view = {{-0.1, 0.68, 0.14}, 0.85, 135, -20},
          .make = Make<HandlePullSide>};
}

}  // namespace metronome::metaworld::tasks::handles
