#include "actor/metaworld/tasks/buttons/button.h"

#include <cmath>

namespace metronome::metaworld::tasks::buttons {
namespace {

constexpr int kFromFront = 1, kFromAbove = 2;  // axes
constexpr double kButtonLength = 0.193;        // metres

}  // namespace

double PressOpenHanded(const Press& press) {
  return 2 * Hamacher(press.opening, press.near).value() +
         (press.tcp_to_button <= 0.05 ? 8 * press.pressed : 0);
}

double PressFromAbove(double gripper, const Press& press) {
  return 5 * Hamacher(gripper, press.near).value() +
         (press.tcp_to_button <= 0.03 ? 5 * press.pressed : 0);
}

Outcome Pressing::Evaluate(const Observation& observation, const Action& /*action*/) {
  const Eigen::Vector3d button = At3(observation.data() + 4, 0);
  const double opening = observation[3];
  const double tcp_to_button = Norm(button - Tcp());
  const double to_target = std::abs(target_[settings_.axis] - button[settings_.axis]);
  const double pressed = LongTail(to_target, 0, 0.005, to_target_init_);
  // The margin moves with the button, as official.
  const double near = LongTail(tcp_to_button, 0, settings_.near_radius, Norm(button - tcp_init_));
  return {settings_.reward({opening, tcp_to_button, near, pressed}),
          {.success = to_target <= settings_.success,
           .near_object = tcp_to_button <= 0.05 ? 1.0 : 0.0,
           .grasp_success = opening > 0 ? 1.0 : 0.0,
           .grasp_reward = near,
           .in_place_reward = pressed,
           .obj_to_target = to_target}};
}

BoxButton::BoxButton(const TaskSpec& task, const EnvironmentOptions& options,
                     const ButtonSettings& settings)
    : Pressing(task, options, settings),
      box_(Body("box")),
      button_(Body("button")),
      slide_(Joint("btnbox_joint")),
      start_(Site("buttonStart")),
      hole_(Site("hole")) {
  face_[settings.axis] = settings.axis == kFromAbove ? kButtonLength : -kButtonLength;
  Remember("_obj_to_target_init", &to_target_init_);
}

void BoxButton::PlaceObject(const RandVec& p) {
  object_init_ = ObjectOf(p);
  if (settings_.axis == kFromFront) {  // pulled out; one from above stays as it has settled
    SetQpos(slide_, {0});
    Stop(slide_, 1);
  }
  Forward();
  target_ = SitePosition(hole_);
  to_target_init_ = std::abs(target_[settings_.axis] - SitePosition(start_)[settings_.axis]);
}

ObjectPose BoxButton::Object() const {
  return {BodyPosition(button_) + face_, BodyQuaternion(button_)};
}

}  // namespace metronome::metaworld::tasks::buttons
