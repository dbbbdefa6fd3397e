#include "actor/metaworld/tasks/pick_place/reach.h"

#include "actor/metaworld/tasks/pick_place/pick_place.h"

/// Bring the hand to a goal in the air. As metaworld 3.1.1 has it: envs/sawyer_reach_v3.py.
namespace metronome::metaworld::tasks::pick_place {

Outcome Reach::Evaluate(const Observation& /*observation*/, const Action& /*action*/) {
  const double to_target = Norm(Tcp() - target_);
  const double in_place = LongTail(to_target, 0, 0.05, Norm(HandInit() - target_));
  // Nothing is grasped: what stands in for it is the official task's.
  return {10 * in_place,
          {.success = to_target <= 0.05,
           .near_object = to_target,
           .grasp_success = 1,
           .grasp_reward = to_target,
           .in_place_reward = in_place,
           .obj_to_target = to_target}};
}

TaskSpec ReachTask() {
  return {.name = "reach",
          .family = "pick_place",
          .scene = "sawyer_xyz/sawyer_reach_v3.xml",
          .success = "the finger tips within 5 cm of the goal",
          .expert = {1.0, 1.0, 4842},
          .low = {-0.1, 0.6, 0.02, -0.1, 0.8, 0.05},
          .high = {0.1, 0.7, 0.02, 0.1, 0.9, 0.3},
          .min_planar_distance = 0.15,
          .hand = {.initial = {0, 0.6, 0.2}},
          .view = {{0.02, 0.72, 0.16}, 0.85, 140, -20},
          .make = Make<Reach>};
}

}  // namespace metronome::metaworld::tasks::pick_place
