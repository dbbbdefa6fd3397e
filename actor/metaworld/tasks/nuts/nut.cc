#include "actor/metaworld/tasks/nuts/nut.h"

#include <algorithm>
#include <cmath>

namespace metronome::metaworld::tasks::nuts {
namespace {

const Eigen::Vector4d kUpright(0.707, 0, 0, 0.707);  // quaternion (w, x, y, z) of a flat wrench

/// Caging takes the object for a ball; along the handle any place is as good.
Eigen::Vector3d Held(Eigen::Vector3d wrench, double hand_x) {
  if (std::abs(wrench.x() - hand_x) < 0.01) wrench.x() = hand_x;
  return wrench;
}

}  // namespace

Nut::Nut(const TaskSpec& task, const EnvironmentOptions& options, const CagingShape& caging)
    : SawyerEnvironment(task, options),
      caging_(caging),
      nut_(Body("RoundNut")),
      peg_(Body("peg")),
      handle_(Site("RoundNut-8")),
      ring_(Site("RoundNut")) {}

ObjectPose Nut::Object() const { return {SitePosition(handle_), BodyQuaternion(nut_)}; }

Outcome Nut::Evaluate(const Observation& observation, const Action& action) {
  const Eigen::Vector3d wrench = At3(observation.data() + 4, 0);
  const Eigen::Vector4d quaternion = Eigen::Map<const Eigen::Vector4d>(observation.data() + 7);
  const double upright = std::max(1 - Norm(quaternion - kUpright) / 0.4, 0.0);
  const Scalar grasp = Caging(Held(wrench, observation[0]), caging_, action[3]);
  const Placed placed = RewardPlace(wrench);

  Scalar reward = (2 * grasp + 6 * placed.reward) * upright;
  if (placed.success) reward = 10;
  return {reward.value(),
          {.success = placed.success,
           .near_object = upright,
           .grasp_success = grasp.value() >= 0.5 ? 1.0 : 0.0,
           .grasp_reward = grasp.value(),
           .in_place_reward = placed.reward,
           .obj_to_target = 0}};
}

}  // namespace metronome::metaworld::tasks::nuts
