#include "actor/metaworld/tasks/pick_place/pick_place.h"
#include "actor/metaworld/tasks/pick_place/reach.h"

/// Bring the hand to a goal behind a wall. As metaworld 3.1.1 has it: envs/sawyer_reach_wall_v3.py.
namespace metronome::metaworld::tasks::pick_place {
namespace {

class ReachWall final : public Reach {
 public:
  using Reach::Reach;

 private:
  Outcome Evaluate(const Observation& observation, const Action& action) override {
    Outcome outcome = Reach::Evaluate(observation, action);
    outcome.info.near_object = outcome.info.grasp_success = outcome.info.grasp_reward = 0;
    return outcome;
  }
};

}  // namespace

TaskSpec ReachWallTask() {
  return {.name = "reach-wall",
          .family = "pick_place",
          .scene = "sawyer_xyz/sawyer_reach_wall_v3.xml",
          .success = "the finger tips within 5 cm of the goal behind the wall",
          .expert = {1.0, 1.0, 4811},
          .low = {-0.05, 0.6, 0.015, -0.05, 0.85, 0.05},
          .high = {0.05, 0.65, 0.015, 0.05, 0.9, 0.3},
          .min_planar_distance = 0.15,
          .hand = {.initial = {0, 0.6, 0.2}},
          .view = {{0.02, 0.74, 0.16}, 0.85, 140, -25},
          .make = Make<ReachWall>};
}

}  // namespace metronome::metaworld::tasks::pick_place
