#include "actor/metaworld/tasks/pick_place/free_object.h"
#include "actor/metaworld/tasks/pick_place/pick_place.h"

/// Put a block into a hole of the table. As metaworld 3.1.1 has it: envs/sawyer_hand_insert_v3.py.
namespace metronome::metaworld::tasks::pick_place {
namespace {

constexpr CagingShape kCaging = {
    .object_radius = 0.015, .pad_success = 0.05, .xz_threshold = 0.005};

class HandInsert final : public Block {
 public:
  HandInsert(const TaskSpec& task, const EnvironmentOptions& options)
      : Block(task, options, "goal") {}

 private:
  void PlaceObject(const RandVec& p) override {
    Place({p[0], p[1], 0.05}, GoalOf(p));  // in the table, which throws it out: as official
  }

  [[nodiscard]] ObjectPose Object() const override {
    return {BodyPosition(object_), BodyQuaternion(object_)};  // of the body, not of its geom
  }

  Outcome Evaluate(const Observation& observation, const Action& action) override {
    const Situation now = See(observation);
    const double in_place = InPlace(now);
    const Scalar grasp = Caging(now.object, kCaging, action[3]);

    Scalar reward = Hamacher(grasp, in_place);
    if (now.to_object < 0.02 && now.opening > 0) reward = reward + (1 + 7 * in_place);
    return Conclude(now, {.reward = reward,
                          .grasp = grasp,
                          .in_place = in_place,
                          .grasped = Held(now),
                          .success_within = 0.05});
  }
};

}  // namespace

TaskSpec HandInsertTask() {
  return {.name = "hand-insert",
          .family = "pick_place",
          .scene = "sawyer_xyz/sawyer_table_with_hole.xml",
          .success = "the block within 5 cm of the goal in the hole",
          .expert = {1.0, 1.0, 4592},
          .low = {-0.1, 0.6, 0.05, -0.04, 0.8, -0.0201},
          .high = {0.1, 0.7, 0.05, 0.04, 0.88, -0.0199},
          .min_planar_distance = 0.15,
          .hand = {.initial = {0, 0.6F, 0.2F}, .low = {-0.5, 0.4, -0.15}},
          .view = {{0, 0.72, 0.1}, 0.8, 140, -30},
          .make = Make<HandInsert>};
}

}  // namespace metronome::metaworld::tasks::pick_place
