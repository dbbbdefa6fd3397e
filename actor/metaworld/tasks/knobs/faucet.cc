#include "actor/metaworld/tasks/knobs/faucet.h"

#include <cmath>

namespace metronome::metaworld::tasks::knobs {

Faucet::Faucet(const TaskSpec& task, const EnvironmentOptions& options,
               const FaucetSettings& settings)
    : SawyerEnvironment(task, options),
      settings_(settings),
      base_(Body("faucetBase")),
      handle_(Site(settings.handle)),
      goal_(Site(settings.goal)) {}

void Faucet::PlaceObject(const RandVec& p) {
  object_init_ = ObjectOf(p);
  target_ = object_init_ + Eigen::Vector3d(settings_.goal_x, 0, 0.125);
  MoveSite(goal_, target_);
  if (settings_.forward) Forward();
}

ObjectPose Faucet::Object() const {
  return {SitePosition(handle_) + Eigen::Vector3d(0, 0, -0.01), BodyQuaternion(base_)};
}

Outcome Faucet::Evaluate(const Observation& observation, const Action& /*action*/) {
  const Eigen::Vector3d grip = At3(observation.data() + 4, 0) + At3(settings_.grip.data(), 0);
  const double tcp_to_grip = Norm(grip - Tcp());
  const double to_target = Norm(grip - target_);
  // From the faucet's base, not from its handle: as official.
  const double in_place =
      LongTail(to_target, 0, 0.07, std::abs(Norm(object_init_ - target_) - 0.07));
  const double reach = Gaussian(tcp_to_grip, 0.01, std::abs(Norm(object_init_ - tcp_init_) - 0.01));
  const bool success = to_target <= 0.07;
  return {success ? 10 : 2 * (2 * reach + 3 * in_place),
          {.success = success,
           .near_object = tcp_to_grip <= 0.01 ? 1.0 : 0.0,
           .grasp_success = 1,
           .grasp_reward = reach,
           .in_place_reward = in_place,
           .obj_to_target = to_target}};
}

}  // namespace metronome::metaworld::tasks::knobs
