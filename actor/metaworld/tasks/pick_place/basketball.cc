#include "actor/metaworld/tasks/pick_place/free_object.h"
#include "actor/metaworld/tasks/pick_place/pick_place.h"

/// Drop a ball into a hoop. As metaworld 3.1.1 has it: envs/sawyer_basketball_v3.py.
namespace metronome::metaworld::tasks::pick_place {
namespace {

constexpr CagingShape kCaging = {
    .object_radius = 0.025, .pad_success = 0.06, .xz_threshold = 0.005};

class Basketball final : public FreeObject {
 public:
  // The hoop has a mark of its own.
  Basketball(const TaskSpec& task, const EnvironmentOptions& options)
      : FreeObject(task, options, "bsktball", nullptr),
        hoop_(Body("basket_goal")),
        goal_(Site("goal")) {}

 private:
  void EditModel(const RandVec& p) override { MoveBody(hoop_, GoalOf(p)); }

  void PlaceObject(const RandVec& p) override {
    object_init_ = {p[0], p[1], 0.03F};  // float32, as official
    SetFreeObject(object_init_);
    target_ = SitePosition(goal_);
  }

  Outcome Evaluate(const Observation& observation, const Action& action) override {
    Situation now = See(observation);
    now.to_target = ToRing(now.object);
    const double in_place = LongTail(now.to_target, 0, 0.08, ToRing(object_init_));
    const bool carried = now.to_object < 0.035 && Lifted(now, 0.01);
    const Scalar grasp = carried ? 1 : Caging(now.object, kCaging, action[3]);

    Scalar reward = Hamacher(grasp, in_place);
    if (carried) reward = reward + (1 + 5 * in_place);
    if (now.to_target < 0.08) reward = 10;
    return Conclude(now, {.reward = reward,
                          .grasp = grasp,
                          .in_place = in_place,
                          .grasped = Lifted(now, 0.03),
                          .success_within = 0.08,
                          .near_within = 0.05});
  }

  /// Height counts twice, and towards the hoop's ring, above the goal that is observed.
  [[nodiscard]] double ToRing(const Eigen::Vector3d& ball) const {
    Eigen::Vector3d error = ball - Eigen::Vector3d(target_.x(), target_.y(), 0.3);
    error.z() *= 2;
    return Norm(error);
  }

  int hoop_, goal_;
};

}  // namespace

TaskSpec BasketballTask() {
  return {.name = "basketball",
          .family = "pick_place",
          .scene = "sawyer_xyz/sawyer_basketball.xml",
          .success = "the ball within 8 cm of the hoop's centre, 4 cm in height",
          .expert = {0.8, 0.8, 3366},
          .low = {-0.1, 0.6, 0.0299, -0.1, 0.85, 0},
          .high = {0.1, 0.7, 0.0301, 0.1, 0.9 + 1e-7, 0},
          .min_planar_distance = 0.15,
          .goal_box = Box{{-0.1, 0.85 - 0.083, 0.2499}, {0.1, 0.9 + 1e-7 - 0.083, 0.2501}},
          .hand = {.initial = {0, 0.6F, 0.2F}},
          .view = {{0, 0.74, 0.18}, 1, 140, -20},
          .make = Make<Basketball>};
}

}  // namespace metronome::metaworld::tasks::pick_place
