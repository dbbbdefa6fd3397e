#include <algorithm>

#include "actor/metaworld/tasks/pick_place/free_object.h"
#include "actor/metaworld/tasks/pick_place/pick_place.h"

/// Push a peg sideways into a hole of a box. As metaworld 3.1.1 has it:
/// envs/sawyer_peg_insertion_side_v3.py.
namespace metronome::metaworld::tasks::pick_place {
namespace {

constexpr CagingShape kCaging = {
    .object_radius = 0.0075, .pad_success = 0.03, .xz_threshold = 0.005};

/// Of the prism between two opposite corners, the share that `point` spans from `zero` on; 1 where
/// it is outside.
double PrismShare(const Eigen::Vector3d& point, const Eigen::Vector3d& zero,
                  const Eigen::Vector3d& one) {
  double share = 1;
  for (int i = 0; i < 3; ++i) {
    if (point[i] < std::min(zero[i], one[i]) || point[i] > std::max(zero[i], one[i])) return 1;
    share *= (point[i] - zero[i]) / (one[i] - zero[i]);
  }
  return share;
}

class PegInsertSide final : public FreeObject {
 public:
  PegInsertSide(const TaskSpec& task, const EnvironmentOptions& options)
      : FreeObject(task, options, "peg", "goal"),
        box_(Body("box")),
        grip_(Site("pegGrasp")),
        head_(Site("pegHead")),
        upper_{Site("bottom_right_corner_collision_box_1"),
               Site("top_left_corner_collision_box_1")},
        lower_{Site("bottom_right_corner_collision_box_2"),
               Site("top_left_corner_collision_box_2")} {
    Remember("peg_head_pos_init", &head_init_);
  }

 private:
  struct Corners {
    int zero, one;  // sites
  };

  void EditModel(const RandVec& p) override { MoveBody(box_, GoalOf(p)); }

  void PlaceObject(const RandVec& p) override {
    head_init_ = SitePosition(head_);  // before the peg is placed: as official
    Place(ObjectOf(p), GoalOf(p) + Eigen::Vector3d(0.03, 0, 0.13));
  }

  [[nodiscard]] ObjectPose Object() const override {
    return {SitePosition(grip_), SiteQuaternion(grip_)};
  }

  Outcome Evaluate(const Observation& observation, const Action& action) override {
    Situation now = See(observation);
    const Eigen::Vector3d head = SitePosition(head_);
    now.to_target = ToHole(head);  // the head's, not the object's
    const bool carried = now.to_object < 0.08 && Lifted(now, 0.01);
    const Scalar grasp = carried ? 1 : Caging(now.object, kCaging, action[3]);
    const double in_place =
        Hamacher(LongTail(now.to_target, 0, 0.07, ToHole(head_init_)), ClearOfBox(head)).value();

    Scalar reward = Hamacher(grasp, in_place);
    if (carried) reward = reward + (1 + 5 * in_place);
    if (now.to_target <= 0.07) reward = 10;
    return Conclude(now, {.reward = reward,
                          .grasp = grasp,
                          .in_place = in_place,
                          .grasped = now.to_object < 0.02 && Lifted(now, 0.01)});
  }

  /// Aside and in height, distances to the hole count twice.
  [[nodiscard]] double ToHole(const Eigen::Vector3d& head) const {
    Eigen::Vector3d error = head - target_;
    error.y() *= 2;
    error.z() *= 2;
    return Norm(error);
  }

  /// 1 but for a head in front of the box's sides, where it would hit them.
  [[nodiscard]] Scalar ClearOfBox(const Eigen::Vector3d& head) const {
    const auto share = [&](const Corners& corners) {
      return PrismShare(head, SitePosition(corners.zero), SitePosition(corners.one));
    };
    return Hamacher(share(lower_), share(upper_));
  }

  int box_, grip_, head_;
  Corners upper_, lower_;
  Eigen::Vector3d head_init_ = Eigen::Vector3d::Zero();
};

}  // namespace

TaskSpec PegInsertSideTask() {
  return {.name = "peg-insert-side",
          .family = "pick_place",
          .scene = "sawyer_xyz/sawyer_peg_insertion_side.xml",
          .success = "the peg's head within 7 cm of the goal in the hole, 3.5 cm crosswise",
          .expert = {0.9, 0.6, 3657},
          .low = {0, 0.5, 0.02, -0.35, 0.4, -0.001},
          .high = {0.2, 0.7, 0.02, -0.25, 0.7, 0.001},
          .min_planar_distance = 0.1,
          .goal_box = Box{{-0.35 + 0.03, 0.4, -0.001 + 0.13}, {-0.25 + 0.03, 0.7, 0.001 + 0.13}},
          .hand = {.initial = {0, 0.6, 0.2}},
          .view = {{-0.08, 0.58, 0.12}, 1, 140, -25},
          .make = Make<PegInsertSide>};
}

}  // namespace metronome::metaworld::tasks::pick_place
