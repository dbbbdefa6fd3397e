#include <algorithm>
#include <cmath>

#include "actor/metaworld/tasks/pick_place/free_object.h"
#include "actor/metaworld/tasks/pick_place/pick_place.h"

/// Put a block on a shelf. As metaworld 3.1.1 has it: envs/sawyer_shelf_place_v3.py.
namespace metronome::metaworld::tasks::pick_place {
namespace {

constexpr CagingShape kCaging = {.object_radius = 0.02,
                                 .pad_success = 0.05,
                                 .xz_threshold = 0.01,
                                 .density = CagingDensity::kPlain};
const Eigen::Vector3d kBoard(0, 0, 0.3);  // on which the goal is, in the shelf
constexpr double kDepth = 0.15;           // of the space under the board, before the goal
constexpr double kHeight = 0.24;

Eigen::Vector3d ShelfOf(const RandVec& placement) { return GoalOf(placement) - kBoard; }

/// `in_place` without what a block has that is on its way under the board.
double WithoutWayBelow(double in_place, const Eigen::Vector3d& block,
                       const Eigen::Vector3d& target) {
  const bool low = 0 < block.z() && block.z() < kHeight;
  if (!low || std::abs(block.x() - target.x()) >= 0.15) return in_place;
  if (block.y() > target.y()) return 0;
  if (block.y() <= target.y() - kDepth || block.y() >= target.y()) return in_place;
  const Scalar below =
      Hamacher((block.y() - target.y() + kDepth) / kDepth, (kHeight - block.z()) / kHeight);
  return std::clamp(in_place - below.value(), 0.0, 1.0);
}

class ShelfPlace final : public Block {
 public:
  ShelfPlace(const TaskSpec& task, const EnvironmentOptions& options)
      : Block(task, options, nullptr), shelf_(Body("shelf")) {}

 private:
  void EditModel(const RandVec& p) override { MoveBody(shelf_, ShelfOf(p)); }

  void PlaceObject(const RandVec& p) override {
    const double height = BodyPosition(object_).z();  // as the block has settled
    Forward();
    Place({p[0], p[1], height}, ShelfOf(p) + kBoard);
  }

  Outcome Evaluate(const Observation& observation, const Action& action) override {
    const Situation now = See(observation);
    double in_place = InPlace(now);
    const Scalar grasp = Caging(now.object, kCaging, action[3]);

    Scalar reward = Hamacher(grasp, in_place);
    in_place = WithoutWayBelow(in_place, now.object, target_);
    if (now.to_object < 0.025 && Lifted(now, 0.01)) reward = reward + (1 + 5 * in_place);
    return Conclude(now,
                    {.reward = reward, .grasp = grasp, .in_place = in_place, .grasped = Held(now)});
  }

  int shelf_;
};

}  // namespace

TaskSpec ShelfPlaceTask() {
  return {.name = "shelf-place",
          .family = "pick_place",
          .scene = "sawyer_xyz/sawyer_shelf_placing.xml",
          .success = "the block within 7 cm of the goal on the shelf",
          .expert = {0.9, 0.4, 2557},
          .low = {-0.1, 0.5, 0.019, -0.1, 0.8, 0.299},
          .high = {0.1, 0.6, 0.021, 0.1, 0.9, 0.301},
          .min_planar_distance = 0.1,
          .hand = {.initial = {0, 0.6F, 0.2F}},
          .view = {{0, 0.7, 0.18}, 1, 140, -20},
          .make = Make<ShelfPlace>};
}

}  // namespace metronome::metaworld::tasks::pick_place
