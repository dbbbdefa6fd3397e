#include "actor/metaworld/funnel.h"
#include "actor/metaworld/tasks/pick_place/free_object.h"
#include "actor/metaworld/tasks/pick_place/pick_place.h"

/// Lift a block out of a hole of the table. As metaworld 3.1.1 has it:
/// envs/sawyer_pick_out_of_hole_v3.py.
namespace metronome::metaworld::tasks::pick_place {
namespace {

constexpr CagingShape kCaging = {
    .object_radius = 0.015, .pad_success = 0.02, .xz_threshold = 0.03, .effort = 0.1};
constexpr Funnel kAroundHole = {.radius = 0.03, .slope = 0.015, .height = 0.15};

class PickOutOfHole final : public FreeObject {
 public:
  PickOutOfHole(const TaskSpec& task, const EnvironmentOptions& options)
      : FreeObject(task, options, "obj", "goal") {}

 private:
  Outcome Evaluate(const Observation& observation, const Action& action) override {
    const Situation now = See(observation);
    const double in_place = InPlace(now, 0.02);
    const Scalar grasp = Caging(now.object, kCaging, action[3]);
    const bool grasped = now.to_object < 0.04 && Lifted(now, 0.02) && !(now.opening < 0.33);

    Scalar reward = Hamacher(grasp, in_place);
    if (grasped) reward = reward + (1 + 5 * Hamacher(in_place, AboveTable()));
    return Conclude(now,
                    {.reward = reward, .grasp = grasp, .in_place = in_place, .grasped = grasped});
  }

  [[nodiscard]] double AboveTable() const {
    const Eigen::Vector3d tcp = Tcp();
    const double radius = Norm((tcp - object_init_).head<2>());
    return AboveFloor(tcp.z(), FunnelHeight(kAroundHole, radius), 0.02);
  }
};

}  // namespace

TaskSpec PickOutOfHoleTask() {
  return {.name = "pick-out-of-hole",
          .family = "pick_place",
          .scene = "sawyer_xyz/sawyer_pick_out_of_hole.xml",
          .success = "the block within 7 cm of the goal in the air",
          .expert = {1.0, 0.6, 3411},
          .low = {0, 0.75, 0.02, -0.1, 0.5, 0.15},
          .high = {0, 0.75, 0.02, 0.1, 0.6, 0.3},
          .min_planar_distance = 0.15,
          .hand = {.initial = {0, 0.6, 0.2}, .low = {-0.5, 0.4, -0.05}},
          .view = {{0, 0.66, 0.15}, 0.85, 140, -30},
          .make = Make<PickOutOfHole>};
}

}  // namespace metronome::metaworld::tasks::pick_place
