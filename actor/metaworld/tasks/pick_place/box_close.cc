#include <algorithm>

#include "actor/metaworld/funnel.h"
#include "actor/metaworld/sawyer.h"
#include "actor/metaworld/tasks/pick_place/pick_place.h"

/// Put a lid on a box. As metaworld 3.1.1 has it: envs/sawyer_box_close_v3.py.
namespace metronome::metaworld::tasks::pick_place {
namespace {

const Eigen::Vector4d kUpright(0.707, 0, 0, 0.707);  // quaternion (w, x, y, z) of a level lid

/// Around the lid's handle, for the hand to come from above.
constexpr Funnel kAroundHandle = {.radius = 0.02, .slope = 0.04, .height = 0.4};

double RewardReady(const Eigen::Vector3d& hand, const Eigen::Vector3d& lid) {
  const double floor = FunnelHeight(kAroundHandle, Norm((hand - lid).head<2>()));
  const double above = AboveFloor(hand.z(), floor, floor / 2);
  return Hamacher(above, LongTail(Norm(hand - lid), 0, 0.02, 0.5)).value();
}

double RewardPlace(const Eigen::Vector3d& lid, const Eigen::Vector3d& target) {
  Eigen::Vector3d error = target - lid;
  error.z() *= 3;
  return 0.2 * (lid.z() > 0.04 ? 1 : 0) + 0.8 * LongTail(Norm(error), 0, 0.05, 0.25);
}

class BoxClose final : public SawyerEnvironment {
 public:
  BoxClose(const TaskSpec& task, const EnvironmentOptions& options)
      : SawyerEnvironment(task, options),
        lid_(Body("top_link")),
        box_(Body("boxbody")),
        goal_(Site("goal")) {}

 private:
  void EditModel(const RandVec& p) override { MoveBody(box_, {p[3], p[4], 0}); }

  void PlaceObject(const RandVec& p) override {
    object_init_ = {p[0], p[1], 0.02F};  // float32, as official
    target_ = GoalOf(p);
    MoveSite(goal_, target_);
    Substeps();
    SetFreeObject(object_init_);
  }

  [[nodiscard]] ObjectPose Object() const override {
    return {BodyPosition(lid_), BodyQuaternion(lid_)};
  }

  Outcome Evaluate(const Observation& observation, const Action& action) override {
    const Eigen::Vector3d hand = At3(observation.data(), 0);
    const Eigen::Vector3d object = At3(observation.data() + 4, 0);
    const Eigen::Vector3d lid = object + Eigen::Vector3d(0, 0, 0.02);
    const Eigen::Vector4d quaternion = Eigen::Map<const Eigen::Vector4d>(observation.data() + 7);
    const double grab = (std::clamp(action[3], -1.0F, 1.0F) + 1.0F) / 2.0F;
    const double upright = std::max(1 - Norm(quaternion - kUpright) / 0.2, 0.0);
    const double ready = RewardReady(hand, lid);
    const double place = RewardPlace(lid, target_);

    double reward = 2 * Hamacher(grab, ready).value() + 8 * place;
    const bool success = Norm(object - target_) < 0.08;
    if (success) reward = 10;
    reward *= upright;  // after the success reward too: no kicking the lid onto the box
    return {reward,
            {.success = success,
             .near_object = ready,
             .grasp_success = grab >= 0.5 ? 1.0 : 0.0,
             .grasp_reward = grab,
             .in_place_reward = place,
             .obj_to_target = 0}};
  }

  int lid_, box_, goal_;
};

}  // namespace

TaskSpec BoxCloseTask() {
  return {.name = "box-close",
          .family = "pick_place",
          .scene = "sawyer_xyz/sawyer_box.xml",
          .success = "the lid within 8 cm of its place on the box",
          .expert = {0.8, 0.5, 2690},
          .low = {-0.05, 0.5, 0.02, -0.1, 0.7, 0.133},
          .high = {0.05, 0.55, 0.02, 0.1, 0.8, 0.133},
          .min_planar_distance = 0.25,
          .hand = {.initial = {0, 0.6F, 0.2F}, .settles_alike = false},
          .view = {{0, 0.65, 0.12}, 0.85, 150, -25},
          .make = Make<BoxClose>};
}

}  // namespace metronome::metaworld::tasks::pick_place
