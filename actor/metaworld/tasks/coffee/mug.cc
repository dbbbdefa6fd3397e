#include "actor/metaworld/tasks/coffee/mug.h"

namespace metronome::metaworld::tasks::coffee {
namespace {

constexpr CagingShape kCaging = {.object_radius = 0.02,
                                 .pad_success = 0.05,
                                 .xz_threshold = 0.05,
                                 .effort = 0.7,
                                 .density = CagingDensity::kMedium,
                                 .reach_radius = 0.04};

/// Length of a way on which height counts half.
double FlatNorm(const Eigen::Vector3d& way) {
  return Norm(Eigen::Vector3d(2 * way.x(), 2 * way.y(), way.z()));
}

}  // namespace

Mug::Mug(const TaskSpec& task, const EnvironmentOptions& options, const MugSettings& settings)
    : SawyerEnvironment(task, options),
      settings_(settings),
      machine_(Body("coffee_machine")),
      mug_(Body("obj")),
      mug_geom_(Geom("mug")),
      goal_(Site("mug_goal")) {}

void Mug::PlaceObject(const RandVec& p) {
  object_init_ = ObjectOf(p);
  target_ = GoalOf(p);
  MoveSite(goal_, target_);
  SetQpos(kMugQpos, {p[0], p[1], p[2]});
  Stop(kStoppedQvel, 6);
  Forward();
}

Outcome Mug::Evaluate(const Observation& observation, const Action& action) {
  const Eigen::Vector3d mug = At3(observation.data() + 4, 0);
  const double opening = observation[3];
  const double tcp_to_mug = Norm(mug - Tcp());
  const double to_target = Norm(mug - target_);
  const double flat = FlatNorm(mug - target_);
  const double in_place = LongTail(flat, 0, 0.05, FlatNorm(object_init_ - target_));
  const Scalar grasp = Caging(mug, kCaging, action[3]);

  Scalar reward = Hamacher(grasp, in_place);
  if (tcp_to_mug < 0.04 && opening > 0) reward = reward + (1 + 5 * in_place);
  if (flat < 0.05) reward = 10;
  return {reward.value(),
          {.success = to_target <= 0.07,
           .near_object = tcp_to_mug <= 0.03 ? 1.0 : 0.0,
           .grasp_success = Pinched(mug_geom_) && opening > 0 ? 1.0 : 0.0,
           .grasp_reward = grasp.value(),
           .in_place_reward = in_place,
           .obj_to_target = to_target}};
}

}  // namespace metronome::metaworld::tasks::coffee
