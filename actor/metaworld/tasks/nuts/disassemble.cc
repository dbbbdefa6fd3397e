#include "actor/metaworld/tasks/nuts/nut.h"
#include "actor/metaworld/tasks/nuts/nuts.h"

/// Lift a wrench's ring off a peg. As metaworld 3.1.1 has it: envs/sawyer_disassemble_peg_v3.py.
namespace metronome::metaworld::tasks::nuts {
namespace {

constexpr CagingShape kCaging = {.object_radius = 0.015, .pad_success = 0.02, .xz_threshold = 0.01};

class Disassemble final : public Nut {
 public:
  Disassemble(const TaskSpec& task, const EnvironmentOptions& options)
      : Nut(task, options, kCaging) {}

 private:
  void EditModel(const RandVec& p) override {
    MoveBody(Peg(), ObjectOf(p) + Eigen::Vector3d(0, 0, 0.03));
  }

  void PlaceObject(const RandVec& p) override {
    object_init_ = ObjectOf(p);
    target_ = object_init_ + Eigen::Vector3d(0, 0, 0.15);  // the placement's goal is not used
    Forward();  // besides SetFreeObject's: each leaves its mark in the solver's warm start
    SetFreeObject(object_init_);
  }

  [[nodiscard]] Placed RewardPlace(const Eigen::Vector3d& wrench) const override {
    const double to_goal = Norm(target_ + Eigen::Vector3d(0, 0, 0.1) - Ring());
    const bool lifted = Ring().z() > 0.02;
    return {0.1 * (lifted ? 1 : 0) + 0.9 * LongTail(to_goal, 0, 0.02, 0.2),
            wrench.z() > target_.z()};
  }
};

}  // namespace

TaskSpec DisassembleTask() {
  return {.name = "disassemble",
          .family = "nuts",
          .scene = "sawyer_xyz/sawyer_assembly_peg.xml",
          .success = "the wrench more than 15 cm above its first place",
          .expert = {1.0, 1.0, 3844},
          .low = {0, 0.6, 0.025, -0.1, 0.6, 0.1699},
          .high = {0.1, 0.75, 0.02501, 0.1, 0.75, 0.1701},
          .min_planar_distance = 0.1,
          .goal_box = Box{{-0.1, 0.6, 0.1699 + 0.005}, {0.1, 0.75, 0.1701 + 0.005}},
          .hand = {.initial = {0, 0.4F, 0.2F}, .settles_alike = false},
          .view = {{0.04, 0.64, 0.16}, 0.8, 140, -20},
          .make = Make<Disassemble>};
}

}  // namespace metronome::metaworld::tasks::nuts
