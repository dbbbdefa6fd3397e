#pragma once

#include "actor/metaworld/sawyer.h"

/// What tasks with a button share.
namespace metronome::metaworld::tasks::buttons {

/// How far a press has come.
struct Press {
  double opening;        // of the gripper, 0..1
  double tcp_to_button;  // metres
  double near, pressed;  // 0..1
};

struct ButtonSettings {
  int axis;            // of the world, along which the button moves
  double near_radius;  // that counts as at the button, metres
  double success;      // distance along the axis, metres
  double (*reward)(const Press&);
};

/// Of the finger tips at the button with an open gripper, and of the button pressed.
double PressOpenHanded(const Press& press);
/// The same from above, for a gripper that is as it should be.
/// @param gripper  how much it is so, 0..1.
double PressFromAbove(double gripper, const Press& press);

/// A button wherever it is: the way to go along one axis decides.
class Pressing : public SawyerEnvironment {
 protected:
  Pressing(const TaskSpec& task, const EnvironmentOptions& options, const ButtonSettings& settings)
      : SawyerEnvironment(task, options), settings_(settings) {}

  Outcome Evaluate(const Observation& observation, const Action& action) final;

  const ButtonSettings& settings_;
  double to_target_init_ = 0;  // along the axis, metres
};

/// The button of the box, which a placement puts somewhere.
class BoxButton final : public Pressing {
 public:
  BoxButton(const TaskSpec& task, const EnvironmentOptions& options,
            const ButtonSettings& settings);

 private:
  void EditModel(const RandVec& p) override { MoveBody(box_, ObjectOf(p)); }
  void PlaceObject(const RandVec& p) override;
  [[nodiscard]] ObjectPose Object() const override;

  int box_, button_, slide_, start_, hole_;
  Eigen::Vector3d face_ = Eigen::Vector3d::Zero();  // of the button, seen from its body's origin
};

}  // namespace metronome::metaworld::tasks::buttons
