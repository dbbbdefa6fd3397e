#include "actor/metaworld/tasks/pushing/pushed_object.h"

namespace metronome::metaworld::tasks::pushing {

PushedObject::PushedObject(const TaskSpec& task, const EnvironmentOptions& options,
                           const PushedSettings& settings)
    : SawyerEnvironment(task, options),
      settings_(settings),
      object_(Body(settings.body)),
      geom_(Geom("objGeom")),
      goal_(Site("goal")) {}

void PushedObject::PlaceObject(const RandVec& placement) {
  const double height = settings_.height.value_or(BodyPosition(object_).z());
  object_init_ = {placement[0], placement[1], height};
  target_ = Goal(placement, height);
  MoveSite(goal_, target_);
  SetFreeObject(object_init_);
}

ObjectPose PushedObject::Object() const { return {BodyPosition(object_), GeomQuaternion(geom_)}; }

Outcome PushedObject::Evaluate(const Observation& observation, const Action& action) {
  const Eigen::Vector3d object = At3(observation.data() + 4, 0), target = GoalFor(object);
  const Moment now = {.object = object,
                      .target = target,
                      .opening = observation[3],
                      .tcp_to_object = Norm(object - Tcp()),
                      .to_target = Norm(object - target)};
  const Reward reward = RewardOf(now, action[3]);
  const bool lifted = !settings_.lifts || object.z() - 0.02 > object_init_.z();
  return {reward.total.value(),
          {.success = now.to_target <= settings_.success,
           .near_object = now.tcp_to_object <= 0.03 ? 1.0 : 0.0,
           .grasp_success = Pinched(geom_) && now.opening > 0 && lifted ? 1.0 : 0.0,
           .grasp_reward = reward.grasp.value(),
           .in_place_reward = reward.in_place,
           .obj_to_target = now.to_target}};
}

}  // namespace metronome::metaworld::tasks::pushing
