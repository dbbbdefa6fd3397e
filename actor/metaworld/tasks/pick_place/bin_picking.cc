#include <algorithm>
#include <optional>

#include "actor/metaworld/funnel.h"
#include "actor/metaworld/sawyer.h"
#include "actor/metaworld/tasks/pick_place/pick_place.h"

/// Carry a cube from one bin to the other. As metaworld 3.1.1 has it:
/// envs/sawyer_bin_picking_v3.py.
namespace metronome::metaworld::tasks::pick_place {
namespace {

constexpr CagingShape kCaging = {
    .object_radius = 0.015, .pad_success = 0.05, .xz_threshold = 0.01, .effort = 0.7};

/// Around each bin's centre, for the hand to clear their walls.
constexpr Funnel kAroundBin = {.radius = 0.03, .slope = 0.02, .height = 0.2};

class BinPicking final : public SawyerEnvironment {
 public:
  BinPicking(const TaskSpec& task, const EnvironmentOptions& options)
      : SawyerEnvironment(task, options), object_(Body("obj")), bin_(Body("bin_goal")) {}

 private:
  void PlaceObject(const RandVec& p) override {
    object_init_ = {p[0], p[1], BodyPosition(object_).z()};  // the cube rests in the bin
    SetFreeObject(object_init_);
    target_ = BodyPosition(bin_);  // the placement's goal part is drawn but not used
    first_distance_.reset();
  }

  [[nodiscard]] ObjectPose Object() const override {
    return {BodyPosition(object_), BodyQuaternion(object_)};
  }

  Outcome Evaluate(const Observation& observation, const Action& action) override {
    const Eigen::Vector3d hand = At3(observation.data(), 0);
    const Eigen::Vector3d object = At3(observation.data() + 4, 0);
    const double to_target = Norm(object - target_);
    if (!first_distance_) first_distance_ = to_target;  // at the first step, not at reset
    const double in_place = LongTail(to_target, 0, 0.05, *first_distance_);
    const Scalar grasp = Caging(object, kCaging, action[3]);

    Scalar reward = Hamacher(grasp, in_place);
    const bool near = Norm(object - hand) < 0.04;
    const bool lifted = object.z() - 0.02 > object_init_.z();
    const bool grasped = near && lifted && !(observation[3] < 0.43);
    if (grasped) reward = reward + (1 + 5 * Hamacher(AboveBins(hand), in_place));
    if (to_target < 0.05) reward = 10;
    return {reward.value(),
            {.success = to_target <= 0.05,
             .near_object = near ? 1.0 : 0.0,
             .grasp_success = grasped ? 1.0 : 0.0,
             .grasp_reward = grasp.value(),
             .in_place_reward = in_place,
             .obj_to_target = to_target}};
  }

  /// 1 while the hand stays above the funnels of both bins, so that it clears their walls.
  [[nodiscard]] double AboveBins(const Eigen::Vector3d& hand) const {
    const double floor = std::min(FunnelHeight(kAroundBin, Norm((hand - object_init_).head<2>())),
                                  FunnelHeight(kAroundBin, Norm((hand - target_).head<2>())));
    return AboveFloor(hand.z(), floor, 0.05);
  }

  int object_, bin_;
  std::optional<double> first_distance_;
};

}  // namespace

TaskSpec BinPickingTask() {
  return {.name = "bin-picking",
          .family = "pick_place",
          .scene = "sawyer_xyz/sawyer_bin_picking.xml",
          .success = "the cube within 5 cm of the other bin's centre",
          .expert = {1.0, 1.0, 3985},
          .low = {-0.21, 0.65, 0.02, 0.1199, 0.699, -0.001},
          .high = {-0.03, 0.75, 0.02, 0.1201, 0.701, 0.001},
          .hand = {.initial = {0, 0.6, 0.2}, .low = {-0.5, 0.4, 0.07}},
          .view = {{0, 0.68, 0.1}, 0.85, 115, -30},
          .make = Make<BinPicking>};
}

}  // namespace metronome::metaworld::tasks::pick_place
