#include "actor/metaworld/tasks/pick_place/pick_place.h"

#include "actor/metaworld/tasks/pick_place/free_object.h"

/// Carry a puck to a goal in the air. As metaworld 3.1.1 has it: envs/sawyer_pick_place_v3.py.
namespace metronome::metaworld::tasks::pick_place {
namespace {

constexpr SignedCagingShape kCaging = {.object_radius = 0.015, .xz_threshold = 0.005};

class PickPlace final : public Block {
 public:
  PickPlace(const TaskSpec& task, const EnvironmentOptions& options)
      : Block(task, options, "goal") {}

 private:
  Outcome Evaluate(const Observation& observation, const Action& action) override {
    const Situation now = See(observation);
    const double in_place = InPlace(now);
    const Scalar grasp = Grasp(now.object, action[3]);

    Scalar reward = Hamacher(grasp, in_place);
    if (now.to_object < 0.02 && Lifted(now, 0.01)) reward = reward + (1 + 5 * in_place);
    return Conclude(now,
                    {.reward = reward, .grasp = grasp, .in_place = in_place, .grasped = Held(now)});
  }

  [[nodiscard]] Scalar Grasp(const Eigen::Vector3d& object, float gripper) const {
    const double caging = SignedCaging(CagingAt(object), kCaging);
    const Scalar closed = caging > 0.97 ? ClosedExtent(gripper, 1) : Scalar(0);
    return (Hamacher(caging, closed) + caging) / 2;
  }
};

}  // namespace

TaskSpec PickPlaceTask() {
  return {.name = "pick-place",
          .family = "pick_place",
          .scene = "sawyer_xyz/sawyer_pick_place_v3.xml",
          .success = "the puck within 7 cm of the goal in the air",
          .expert = {1.0, 1.0, 4305},
          .low = {-0.1, 0.6, 0.02, -0.1, 0.8, 0.05},
          .high = {0.1, 0.7, 0.02, 0.1, 0.9, 0.3},
          .min_planar_distance = 0.15,
          .hand = {.initial = {0, 0.6, 0.2}},
          .view = {{0.02, 0.72, 0.16}, 0.85, 140, -20},
          .make = Make<PickPlace>};
}

}  // namespace metronome::metaworld::tasks::pick_place
