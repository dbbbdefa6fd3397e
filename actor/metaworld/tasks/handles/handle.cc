#include "actor/metaworld/tasks/handles/handle.h"

#include <cmath>

namespace metronome::metaworld::tasks::handles {
namespace {

constexpr int kSlide = 9;  // the handle in qpos and qvel: after 7 arm and 2 finger joints

}  // namespace

Handle::Handle(const TaskSpec& task, const EnvironmentOptions& options, const char* handle,
               const char* goal, double slide)
    : SawyerEnvironment(task, options),
      box_(Body("box")),
      handle_(Site(handle)),
      goal_(Site(goal)),
      slide_(slide) {}

void Handle::PlaceObject(const RandVec& placement) {
  SetQpos(kSlide, {slide_});
  Stop(kSlide, 1);
  Forward();
  object_init_ = ObjectOf(placement);
  target_ = SitePosition(goal_);
}

HandlePress::HandlePress(const TaskSpec& task, const EnvironmentOptions& options)
    : Handle(task, options, "handleStart", "goalPress", -0.001) {
  Remember("_handle_init_pos", &handle_init_);
}

void HandlePress::PlaceObject(const RandVec& placement) {
  Handle::PlaceObject(placement);
  handle_init_ = HandlePosition();
}

Outcome HandlePress::Evaluate(const Observation& /*observation*/, const Action& /*action*/) {
  const Eigen::Vector3d handle = HandlePosition();
  const double tcp_to_handle = Norm(handle - Tcp());
  const double to_target = std::abs(handle.z() - target_.z());
  const double in_place =
      LongTail(to_target, 0, 0.02, std::abs(std::abs(handle_init_.z() - target_.z()) - 0.02));
  const double reach =
      LongTail(tcp_to_handle, 0, 0.02, std::abs(Norm(handle_init_ - tcp_init_) - 0.02));
  const bool success = to_target <= 0.02;
  return {success ? 10 : 10 * Hamacher(reach, in_place).value(),
          {.success = success,
           .near_object = tcp_to_handle <= 0.05 ? 1.0 : 0.0,
           .grasp_success = 1,
           .grasp_reward = reach,
           .in_place_reward = in_place,
           .obj_to_target = to_target}};
}

HandlePull::HandlePull(const TaskSpec& task, const EnvironmentOptions& options, const char* handle,
                       const CagingShape& caging, double success)
    : Handle(task, options, handle, "goalPull", -0.1), caging_(caging), success_(success) {}

Outcome HandlePull::Evaluate(const Observation& observation, const Action& action) {
  const Eigen::Vector3d handle = HandlePosition();
  const bool open = observation[3] > 0;
  const double tcp_to_handle = Norm(handle - Tcp());
  const double to_target = ToTarget(handle);
  const double in_place = LongTail(to_target, 0, 0.05, ToTarget(object_init_));
  const Scalar grasp = Caging(handle, caging_, action[3]);

  Scalar reward = Hamacher(grasp, in_place);
  if (tcp_to_handle < 0.035 && open && Moved(handle)) reward = reward + (1 + 5 * in_place);
  if (to_target < 0.05) reward = 10;
  return {reward.value(),
          {.success = to_target <= success_,
           .near_object = tcp_to_handle <= 0.05 ? 1.0 : 0.0,
           .grasp_success = open && handle.z() - 0.03 > object_init_.z() ? 1.0 : 0.0,
           .grasp_reward = grasp.value(),
           .in_place_reward = in_place,
           .obj_to_target = to_target}};
}

}  // namespace metronome::metaworld::tasks::handles
