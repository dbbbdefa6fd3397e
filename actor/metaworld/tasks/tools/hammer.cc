#include <algorithm>
#include <cmath>

#include "actor/metaworld/sawyer.h"
#include "actor/metaworld/tasks/tools/tools.h"

/// Drive a nail in with a hammer. As metaworld 3.1.1 has it: envs/sawyer_hammer_v3.py.
namespace metronome::metaworld::tasks::tools {
namespace {

constexpr CagingShape kCaging = {.object_radius = 0.015, .pad_success = 0.02, .xz_threshold = 0.01};
const Eigen::Vector4d kUpright(1, 0, 0, 0);  // quaternion (w, x, y, z) of a level hammer

class Hammer final : public SawyerEnvironment {
 public:
  Hammer(const TaskSpec& task, const EnvironmentOptions& options)
      : SawyerEnvironment(task, options),
        hammer_(Body("hammer")),
        nail_(Body("nail_link")),
        goal_(Site("goal")),
        nail_slide_(Joint("NailSlideJoint")) {}

 private:
  void PlaceObject(const RandVec& p) override {
    target_ = SitePosition(goal_);
    object_init_ = ObjectOf(p);
    SetFreeObject(object_init_);  // inside the table, which throws it out: as official
  }

  [[nodiscard]] ObjectPose Object() const override {
    return {BodyPosition(hammer_), BodyQuaternion(hammer_)};
  }
  [[nodiscard]] ObjectPose SecondObject() const override {
    return {BodyPosition(nail_), BodyQuaternion(nail_)};
  }

  Outcome Evaluate(const Observation& observation, const Action& action) override {
    const Eigen::Vector3d hammer = At3(observation.data() + 4, 0);
    const Eigen::Vector4d quaternion = Eigen::Map<const Eigen::Vector4d>(observation.data() + 7);
    const double upright = std::max(1 - Norm(quaternion - kUpright) / 0.4, 0.0);
    const Scalar grasp = Caging(Held(hammer, observation[0]), kCaging, action[3]);
    const double in_place = RewardPlace(hammer);

    Scalar reward = (2 * grasp + 6 * in_place) * upright;
    const bool success = data_->qpos[nail_slide_] > 0.09;
    if (success && reward.value() > 5) reward = 10;
    return {reward.value(),
            {.success = success,
             .near_object = upright,
             .grasp_success = grasp.value() >= 0.5 ? 1.0 : 0.0,
             .grasp_reward = grasp.value(),
             .in_place_reward = in_place,
             .obj_to_target = 0}};
  }

  /// Caging takes the object for a ball; along the shaft any place is as good.
  static Eigen::Vector3d Held(Eigen::Vector3d hammer, double hand_x) {
    if (std::abs(hammer.x() - hand_x) < 0.07) hammer.x() = hand_x;
    return hammer;
  }

  /// How near the head is to the nail driven in; the hammer's rotation does not count, as official.
  [[nodiscard]] double RewardPlace(const Eigen::Vector3d& hammer) const {
    const Eigen::Vector3d head = hammer + Eigen::Vector3d(0.16, 0.06, 0);
    return 0.1 * (head.z() > 0.02 ? 1 : 0) + 0.9 * LongTail(Norm(target_ - head), 0, 0.02, 0.2);
  }

  const int hammer_, nail_, goal_, nail_slide_;
};

}  // namespace

TaskSpec HammerTask() {
  return {.name = "hammer",
          .family = "tools",
          .scene = "sawyer_xyz/sawyer_hammer.xml",
          .success = "the nail driven in by more than 9 cm",
          .expert = {1.0, 1.0, 2491},
          .placement_size = 3,
          .low = {-0.1, 0.4, 0},
          .high = {0.1, 0.5, 0},
          .goal_box = Box{{0.2399, 0.7399, 0.109}, {0.2401, 0.7401, 0.111}},
          .hand = {.initial = {0, 0.4, 0.2}},
          .view = {{0.1, 0.58, 0.12}, 0.95, 130, -20},
          .make = Make<Hammer>};
}

}  // namespace metronome::metaworld::tasks::tools
