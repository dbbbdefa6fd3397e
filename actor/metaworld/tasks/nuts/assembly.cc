#include "actor/metaworld/tasks/nuts/nut.h"
#include "actor/metaworld/tasks/nuts/nuts.h"
#include "common/numbers/elementary.h"

/// Put a wrench's ring over a peg. As metaworld 3.1.1 has it: envs/sawyer_assembly_peg_v3.py.
namespace metronome::metaworld::tasks::nuts {
namespace {

constexpr CagingShape kCaging = {.object_radius = 0.015,
                                 .pad_success = 0.02,
                                 .xz_threshold = 0.01,
                                 .density = CagingDensity::kMedium};

class Assembly final : public Nut {
 public:
  Assembly(const TaskSpec& task, const EnvironmentOptions& options)
      : Nut(task, options, kCaging), peg_top_(Site("pegTop")) {}

 private:
  void EditModel(const RandVec& p) override {
    MoveBody(Peg(), GoalOf(p) - Eigen::Vector3d(0, 0, 0.05));
    // A position in the peg's frame, hence in a wrong place of the world: as official, and
    // harmless.
    MoveSite(peg_top_, GoalOf(p));
  }

  void PlaceObject(const RandVec& p) override {
    object_init_ = ObjectOf(p);
    target_ = GoalOf(p);
    SetFreeObject(object_init_);
  }

  /// How near the ring's centre is to sitting on the peg, by a funnel over the peg.
  [[nodiscard]] Placed RewardPlace(const Eigen::Vector3d& /*wrench*/) const override {
    const Eigen::Vector3d ring = Ring();
    Eigen::Vector3d error = target_ - ring;
    const double radius = Norm(error.head<2>());
    const bool success = radius < 0.02 && error.z() > 0;
    const double threshold = success ? 0.02 : 0.01;
    const double height = radius > threshold ? 0.02 * numbers::Log(radius - threshold) + 0.2 : 0;
    error.z() = (height - ring.z()) * 3;
    const bool lifted = ring.z() > 0.02 || radius < threshold;
    return {0.1 * (lifted ? 1 : 0) + 0.9 * LongTail(Norm(error), 0, 0.02, 0.4), success};
  }

  const int peg_top_;
};

}  // namespace

TaskSpec AssemblyTask() {
  return {
      .name = "assembly",
      .family = "nuts",
      .scene = "sawyer_xyz/sawyer_assembly_peg.xml",
      .success = "the ring around the peg: its centre within 2 cm of the peg's and below its top",
      .expert = {1.0, 1.0, 4315},
      .low = {0, 0.6, 0.02, -0.1, 0.75, 0.1},
      .high = {0, 0.6, 0.02, 0.1, 0.85, 0.1},
      .min_planar_distance = 0.1,
      .hand = {.initial = {0, 0.6F, 0.2F}},
      .view = {{0.02, 0.7, 0.14}, 0.75, 140, -20},
      .make = Make<Assembly>};
}

}  // namespace metronome::metaworld::tasks::nuts
