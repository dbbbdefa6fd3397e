#include "actor/metaworld/tasks/pick_place/free_object.h"

namespace metronome::metaworld::tasks::pick_place {

FreeObject::FreeObject(const TaskSpec& task, const EnvironmentOptions& options, const char* body,
                       const char* mark)
    : SawyerEnvironment(task, options),
      object_(Body(body)),
      mark_(mark != nullptr ? std::optional(Site(mark)) : std::nullopt) {}

void FreeObject::Place(const Eigen::Vector3d& object, const Eigen::Vector3d& target) {
  object_init_ = object;
  SetTarget(target);
  SetFreeObject(object);
}

void FreeObject::SetTarget(const Eigen::Vector3d& target) {
  target_ = target;
  if (mark_) MoveSite(*mark_, target);
}

FreeObject::Situation FreeObject::See(const Observation& observation) const {
  const Eigen::Vector3d object = At3(observation.data() + 4, 0);
  return {.object = object,
          .opening = observation[3],
          .to_object = Norm(object - Tcp()),
          .to_target = Norm(object - target_)};
}

double FreeObject::InPlace(const Situation& now, double within) const {
  return LongTail(now.to_target, 0, within, Norm(object_init_ - target_));
}

Outcome FreeObject::Conclude(const Situation& now, const Terms& terms) {
  return {now.to_target < 0.05 ? 10 : terms.reward.value(),
          {.success = now.to_target <= terms.success_within,
           .near_object = now.to_object <= terms.near_within ? 1.0 : 0.0,
           .grasp_success = terms.grasped ? 1.0 : 0.0,
           .grasp_reward = terms.grasp.value(),
           .in_place_reward = terms.in_place,
           .obj_to_target = now.to_target}};
}

}  // namespace metronome::metaworld::tasks::pick_place
