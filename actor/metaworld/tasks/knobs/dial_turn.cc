#include <cmath>

#include "actor/metaworld/sawyer.h"
#include "actor/metaworld/tasks/knobs/knobs.h"
#include "common/numbers/elementary.h"

/// Turn a dial half round. As metaworld 3.1.1 has it: envs/sawyer_dial_turn_v3.py.
namespace metronome::metaworld::tasks::knobs {
namespace {

constexpr double kRadius = 0.05;                  // of the dial's tip, metres
const Eigen::Vector3d kToGrip(0.05, 0.02, 0.09);  // from the tip to where the finger tips push

class DialTurn final : public SawyerEnvironment {
 public:
  DialTurn(const TaskSpec& task, const EnvironmentOptions& options)
      : SawyerEnvironment(task, options),
        dial_(Body("dial")),
        knob_(Joint("knob_Joint_1")),
        goal_(Site("goal")) {
    Remember("dial_push_position", &grip_init_);
  }

 private:
  void EditModel(const RandVec& p) override { MoveBody(dial_, ObjectOf(p)); }

  void PlaceObject(const RandVec& p) override {
    object_init_ = ObjectOf(p);
    target_ = object_init_ + Eigen::Vector3d(0, 0.03, 0.03);
    MoveSite(goal_, target_);
    grip_init_ = Tip() + kToGrip;
  }

  [[nodiscard]] ObjectPose Object() const override { return {Tip(), BodyQuaternion(dial_)}; }

  Outcome Evaluate(const Observation& observation, const Action& action) override {
    const Eigen::Vector3d tip = At3(observation.data() + 4, 0);
    const double tcp_to_grip = Norm(tip + kToGrip - Tcp());
    const double to_target = Norm(tip - target_);
    const double in_place =
        LongTail(to_target, 0, 0.07, std::abs(Norm(grip_init_ - target_) - 0.07));
    const double near =
        Gaussian(tcp_to_grip, 0.005, std::abs(Norm(grip_init_ - tcp_init_) - 0.005));
    const Scalar reach = Hamacher(near, ClosedExtent(action[3], 1));
    return {(10 * Hamacher(reach, in_place)).value(),
            {.success = to_target <= 0.07,
             .near_object = tcp_to_grip <= 0.01 ? 1.0 : 0.0,
             .grasp_success = 1,
             .grasp_reward = reach.value(),
             .in_place_reward = in_place,
             .obj_to_target = to_target}};
  }

  [[nodiscard]] Eigen::Vector3d Tip() const {
    const double angle = data_->qpos[knob_];
    return BodyPosition(dial_) +
           kRadius * Eigen::Vector3d(numbers::Sin(angle), -numbers::Cos(angle), 0);
  }

  int dial_, knob_, goal_;
  Eigen::Vector3d grip_init_ = Eigen::Vector3d::Zero();
};

}  // namespace

TaskSpec DialTurnTask() {
  return {.name = "dial-turn",
          .family = "knobs",
          .scene = "sawyer_xyz/sawyer_dial.xml",
          .success = "the dial's tip within 7 cm of the goal on the far side",
          .expert = {1.0, 1.0, 4039},
          .placement_size = 3,
          .low = {-0.1, 0.7, 0},
          .high = {0.1, 0.8, 0},
          .goal_box = Box{{-0.1, 0.73, 0.0299}, {0.1, 0.83, 0.0301}},
          .hand = {.initial = {0, 0.6F, 0.2F}},
          .view = {{0.03, 0.72, 0.12}, 0.75, 140, -30},
          .make = Make<DialTurn>};
}

}  // namespace metronome::metaworld::tasks::knobs
