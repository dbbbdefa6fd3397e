#include "actor/metaworld/tasks/pick_place/free_object.h"
#include "actor/metaworld/tasks/pick_place/pick_place.h"

/// Carry a puck over a wall to a goal in the air. As metaworld 3.1.1 has it:
/// envs/sawyer_pick_place_wall_v3.py.
namespace metronome::metaworld::tasks::pick_place {
namespace {

constexpr CagingShape kCaging = {.object_radius = 0.015,
                                 .pad_success = 0.05,
                                 .xz_threshold = 0.005,
                                 .density = CagingDensity::kPlain};

class PickPlaceWall final : public Block {
 public:
  PickPlaceWall(const TaskSpec& task, const EnvironmentOptions& options)
      : Block(task, options, "goal") {}

 private:
  Outcome Evaluate(const Observation& observation, const Action& action) override {
    const Situation now = See(observation);
    const double over_wall = LongTail(ToWallTop(now.object), 0, 0.05, ToWallTop(object_init_));
    const double in_place = InPlace(now);
    const Scalar grasp = Caging(now.object, kCaging, action[3]);

    Scalar reward = Hamacher(grasp, over_wall);
    if (now.to_object < 0.02 && Lifted(now, 0.015)) {
      const bool past_wall = now.object.y() > 0.75;
      reward = past_wall ? reward + 1 + 4 + 3 * in_place : reward + 1 + 4 * over_wall;
    }
    return Conclude(now,
                    {.reward = reward, .grasp = grasp, .in_place = in_place, .grasped = Held(now)});
  }

  /// To a point above the wall on the way to the goal; height counts thrice.
  [[nodiscard]] double ToWallTop(const Eigen::Vector3d& object) const {
    Eigen::Vector3d error = object - Eigen::Vector3d(target_.x(), 0.77, 0.25);
    error.z() *= 3;
    return Norm(error);
  }
};

}  // namespace

TaskSpec PickPlaceWallTask() {
  return {.name = "pick-place-wall",
          .family = "pick_place",
          .scene = "sawyer_xyz/sawyer_pick_place_wall_v3.xml",
          .success = "the puck within 7 cm of the goal in the air, behind the wall",
          .expert = {1.0, 1.0, 4280},
          .low = {-0.05, 0.6, 0.015, -0.05, 0.85, 0.05},
          .high = {0.05, 0.65, 0.015, 0.05, 0.9, 0.3},
          .min_planar_distance = 0.15,
          .hand = {.initial = {0, 0.6, 0.2}},
          .view = {{0.02, 0.74, 0.16}, 0.85, 140, -25},
          .make = Make<PickPlaceWall>};
}

}  // namespace metronome::metaworld::tasks::pick_place
