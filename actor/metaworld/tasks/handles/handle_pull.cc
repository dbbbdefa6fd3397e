#include <cmath>

#include "actor/metaworld/tasks/handles/handle.h"
#include "actor/metaworld/tasks/handles/handles.h"

/// Pull a handle up. As metaworld 3.1.1 has it: envs/sawyer_handle_pull_v3.py.
namespace metronome::metaworld::tasks::handles {
namespace {

constexpr CagingShape kCaging = {.object_radius = 0.022, .pad_success = 0.05, .xz_threshold = 0.01};

class HandlePullFront final : public HandlePull {
 public:
  HandlePullFront(const TaskSpec& task, const EnvironmentOptions& options)
      : HandlePull(task, options, "handleRight", kCaging, 0.05) {}

 private:
  [[nodiscard]] double ToTarget(const Eigen::Vector3d& place) const override {
    return std::abs(target_.z() - place.z());
  }
  /// The official task compares y with the height of the box, hence finds it so at any time.
  [[nodiscard]] bool Moved(const Eigen::Vector3d& place) const override {
    return place.y() - 0.01 > object_init_.z();
  }
};

}  // namespace

TaskSpec HandlePullTask() {
  return {.name = "handle-pull",
          .family = "handles",
          .scene = "sawyer_xyz/sawyer_handle_press.xml",
          .success = "the handle within 5 cm of the height of the goal",
          .expert = {1.0, 1.0, 4010},
          .placement_size = 3,
          .low = {-0.1, 0.8, -0.001},
          .high = {0.1, 0.9, 0.001},
          .goal_box = Box{{-0.1, 0.55, 0.04}, {0.1, 0.7, 0.18}},
          .hand = {.initial = {0, 0.6, 0.2}, .settles_alike = false},
          .view = {{0.02, 0.68, 0.16}, 0.8, 140, -20},
          .make = Make<HandlePullFront>};
}

}  // namespace metronome::metaworld::tasks::handles
