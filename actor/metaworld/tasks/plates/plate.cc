#include "actor/metaworld/tasks/plates/plate.h"

namespace metronome::metaworld::tasks::plates {

Plate::Plate(const TaskSpec& task, const EnvironmentOptions& options, const PlateSettings& settings)
    : SawyerEnvironment(task, options),
      settings_(settings),
      plate_(Geom("puck")),
      frame_(Body("puck_goal")),
      goal_(Site("goal")),
      slides_(Joint("goal_slidex")) {}

void Plate::PlaceObject(const RandVec& placement) {
  object_init_ = ObjectOf(placement);
  target_ = GoalOf(placement);
  MoveSite(goal_, target_);
  SetQpos(slides_, {settings_.x, settings_.y});  // velocities are kept, as official
  Forward();
}

ObjectPose Plate::Object() const { return {GeomPosition(plate_), GeomQuaternion(plate_)}; }

Outcome Plate::Evaluate(const Observation& observation, const Action& /*action*/) {
  const Eigen::Vector3d plate = At3(observation.data() + 4, 0);
  const double tcp_to_plate = Norm(plate - Tcp());
  const double to_target = Norm(plate - target_);
  const double in_place =
      LongTail(to_target, 0, 0.05, Norm(object_init_ - target_) - settings_.slack);
  const double grasp =
      LongTail(tcp_to_plate, 0, 0.05, Norm(tcp_init_ - object_init_) - settings_.slack);
  return {to_target < 0.05 ? 10 : Reward(tcp_to_plate, grasp, in_place),
          {.success = to_target <= 0.07,
           .near_object = tcp_to_plate <= 0.03 ? 1.0 : 0.0,
           .grasp_success = 0,
           .grasp_reward = grasp,
           .in_place_reward = in_place,
           .obj_to_target = to_target}};
}

double Plate::Reward(double tcp_to_plate, double grasp, double in_place) const {
  const bool held = Tcp().z() <= 0.03 && tcp_to_plate < 0.07;
  return held ? 2 + 7 * in_place : 1.5 * grasp;
}

}  // namespace metronome::metaworld::tasks::plates
