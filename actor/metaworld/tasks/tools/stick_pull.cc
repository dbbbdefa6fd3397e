#include <cmath>

#include "actor/metaworld/tasks/tools/stick.h"
#include "actor/metaworld/tasks/tools/tools.h"

/// Put a stick through a container's handle and pull the container with it. As metaworld 3.1.1 has
/// it: envs/sawyer_stick_pull_v3.py.
namespace metronome::metaworld::tasks::tools {
namespace {

constexpr CagingShape kCaging = {.object_radius = 0.014, .pad_success = 0.05, .xz_threshold = 0.01};
const Eigen::Vector3d kContainer(0.05, 0, 0);  // from the handle, and official from `object`, too
const Eigen::Vector3d kScale(1, 1, 2);

class StickPull final : public Stick {
 public:
  StickPull(const TaskSpec& task, const EnvironmentOptions& options)
      : Stick(task, options, 0.09, 0), stick_end_(Site("stick_end")) {}

 private:
  [[nodiscard]] double GoalHeight() const override { return 0.02; }

  Outcome Evaluate(const Observation& observation, const Action& action) override {
    const Eigen::Vector3d stick = At3(observation.data() + 4, 0);
    const Eigen::Vector3d handle = At3(observation.data() + 11, 0);
    const double tcp_to_stick = Norm(stick - Tcp());
    const double to_target = Norm(handle - target_);
    const double at_handle = ToContainer(stick, handle);
    const bool inserted = Inserted(handle);
    const bool held =
        tcp_to_stick < 0.02 && observation[3] > 0 && stick.z() - 0.01 > StickInit().z();
    const Scalar grasp = held ? 1 : Caging(stick, kCaging, action[3]);

    Scalar reward = Hamacher(grasp, at_handle);
    if (held && !inserted) reward = 1 + reward + 5 * at_handle;
    if (held && inserted)
      reward = to_target <= 0.12 ? 10 : 1 + reward + 5 + 2 * StickInPlace(stick) + InPlace(handle);
    return {reward.value(),
            {.success = to_target <= 0.12 && inserted,
             .near_object = tcp_to_stick <= 0.03 ? 1.0 : 0.0,
             .grasp_success = Grasped(observation, 0.02, object_init_.z()) ? 1.0 : 0.0,
             .grasp_reward = grasp.value(),
             .in_place_reward = at_handle,
             .obj_to_target = to_target}};
  }

  [[nodiscard]] double ToContainer(const Eigen::Vector3d& stick,
                                   const Eigen::Vector3d& handle) const {
    const Eigen::Vector3d now = stick - (handle + kContainer);
    const Eigen::Vector3d first = StickInit() - (object_init_ + kContainer);
    return LongTail(Norm(now.cwiseProduct(kScale)), 0, 0.05, Norm(first.cwiseProduct(kScale)));
  }
  [[nodiscard]] double StickInPlace(const Eigen::Vector3d& stick) const {
    return LongTail(Norm(stick - target_), 0, 0.05, Norm(StickInit() - target_));
  }
  [[nodiscard]] double InPlace(const Eigen::Vector3d& handle) const {
    return LongTail(Norm(handle + kContainer - target_), 0, 0.05, Norm(object_init_ - target_));
  }

  /// Whether the stick's end is in or beyond the container's handle.
  [[nodiscard]] bool Inserted(const Eigen::Vector3d& handle) const {
    const Eigen::Vector3d beyond = SitePosition(stick_end_) - handle;
    return SitePosition(stick_end_).x() >= handle.x() && std::abs(beyond.y()) <= 0.04 &&
           std::abs(beyond.z()) <= 0.06;
  }

  const int stick_end_;
};

}  // namespace

TaskSpec StickPullTask() {
  return {.name = "stick-pull",
          .family = "tools",
          .scene = "sawyer_xyz/sawyer_stick_obj.xml",
          .success = "the container's handle within 12 cm of the goal, the stick through it",
          .expert = {1.0, 0.2, 434},
          .low = {-0.1, 0.55, 0, 0.35, 0.45, 0.0199},
          .high = {0, 0.65, 0.001, 0.45, 0.55, 0.0201},
          .min_planar_distance = 0.1,
          .hand = {.initial = {0, 0.6, 0.2}, .low = {-0.5, 0.35, 0.05}},
          .view = {{0.14, 0.58, 0.14}, 1, 120, -20},
          .make = Make<StickPull>};
}

}  // namespace metronome::metaworld::tasks::tools
