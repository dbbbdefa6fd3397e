#include "actor/metaworld/tasks/windows/window.h"

#include <cmath>

namespace metronome::metaworld::tasks::windows {
namespace {

constexpr double kTravel = 0.2;  // metres

}  // namespace

Window::Window(const TaskSpec& task, const EnvironmentOptions& options,
               const WindowSettings& settings)
    : SawyerEnvironment(task, options),
      settings_(settings),
      window_(Body("window")),
      slide_(Joint("window_slide")),
      handle_(Site(settings.handle)),
      goal_(Site("goal")) {
  Remember("window_handle_pos_init", &handle_init_);
}

void Window::PlaceObject(const RandVec& p) {
  object_init_ = ObjectOf(p);
  target_ = object_init_ + Eigen::Vector3d(kTravel - settings_.start, 0, 0);
  MoveSite(goal_, target_);
  handle_init_ = SitePosition(handle_) + Eigen::Vector3d(settings_.start, 0, 0);
  // No mj_forward, as official: the first observation shows the handle where it has settled.
  SetQpos(slide_, {settings_.start});
}

Outcome Window::Evaluate(const Observation& observation, const Action& /*action*/) {
  const Eigen::Vector3d handle = At3(observation.data() + 4, 0);
  const double tcp_to_handle = Norm(handle - Tcp());
  const double to_target = std::abs(handle.x() - target_.x());
  const double from = (settings_.from_handle ? handle_init_ : object_init_).x();
  const double in_place =
      LongTail(to_target, 0, 0.05, std::abs(std::abs(from - target_.x()) - 0.05));
  const double reach =
      settings_.near(tcp_to_handle, std::abs(Norm(handle_init_ - tcp_init_) - kNearRadius));
  return {10 * Hamacher(reach, in_place).value(),
          {.success = to_target <= 0.05,
           .near_object = tcp_to_handle <= 0.05 ? 1.0 : 0.0,
           .grasp_success = 1,
           .grasp_reward = reach,
           .in_place_reward = in_place,
           .obj_to_target = to_target}};
}

}  // namespace metronome::metaworld::tasks::windows
