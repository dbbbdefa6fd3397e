#include <algorithm>
#include <cmath>

#include "actor/metaworld/sawyer.h"

/// Put a lid on a box. As metaworld 3.1.1 has it: envs/sawyer_box_close_v3.py.
namespace metronome::metaworld::tasks {
namespace {

const Eigen::Vector4d kUpright(0.707, 0, 0, 0.707);  // quaternion (w, x, y, z) of a level lid

/// 1 while the hand stays above a funnel around the lid's handle, so that it comes from above.
double AboveFloor(const Eigen::Vector3d& hand, const Eigen::Vector3d& lid) {
  const double radius = Norm((hand - lid).head<2>());
  const double floor = radius <= 0.02 ? 0 : 0.04 * std::log(radius - 0.02) + 0.4;
  return hand.z() >= floor ? 1 : LongTail(floor - hand.z(), 0, 0.01, floor / 2);
}

double RewardReady(const Eigen::Vector3d& hand, const Eigen::Vector3d& lid) {
  return Hamacher(AboveFloor(hand, lid), LongTail(Norm(hand - lid), 0, 0.02, 0.5)).value();
}

double RewardPlace(const Eigen::Vector3d& lid, const Eigen::Vector3d& target) {
  Eigen::Vector3d error = target - lid;
  error.z() *= 3;
  return 0.2 * (lid.z() > 0.04 ? 1 : 0) + 0.8 * LongTail(Norm(error), 0, 0.05, 0.25);
}

class BoxClose final : public SawyerEnvironment {
 public:
  BoxClose(const TaskSpec& task, const EnvironmentOptions& options)
      // The official task keeps the initial hand position in float32.
      : SawyerEnvironment(task, options,
                          {{0, 0.6F, 0.2F}, {-0.5, 0.4, 0.05}, {0.5, 1, 0.5}, false}),
        lid_(Body("top_link")),
        box_(Body("boxbody")),
        goal_(Site("goal")) {}

 private:
  void EditModel(const RandVec& p) override {
    model_->body_pos[3 * box_] = p[3];
    model_->body_pos[3 * box_ + 1] = p[4];
  }

  void PlaceObject(const RandVec& p) override {
    object_init_ = {p[0], p[1], 0.02F};  // float32, as official
    target_ = {p[3], p[4], p[5]};
    Eigen::Map<Eigen::Vector3d>(model_->site_pos + 3 * goal_) = target_;
    Substeps();
    SetObject(object_init_);
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

std::unique_ptr<SawyerEnvironment> MakeBoxClose(const TaskSpec& task,
                                                const EnvironmentOptions& options) {
  return std::make_unique<BoxClose>(task, options);
}

}  // namespace metronome::metaworld::tasks
