#pragma once

#include <cmath>

#include "actor/metaworld/sawyer.h"

/// What tasks with a door's lock share.
namespace metronome::metaworld::tasks::doors {

/// How near the gripper is to the lock.
struct LockReach {
  double distance;  // metres, scaled by axis
  double reward;    // 0..1
  double share;     // of it in the step's reward, 0..1
};

/// Length of a way to the lock: the most counts along the door's normal.
inline double ReachNorm(const Eigen::Vector3d& way) {
  return Norm(Eigen::Vector3d(0.25 * way.x(), way.y(), 0.5 * way.z()));
}

class Lock : public SawyerEnvironment {
 protected:
  /// @param knob  site that is observed. @param axis  of the world, along which it has to go.
  Lock(const TaskSpec& task, const EnvironmentOptions& options, const char* knob, int axis)
      : SawyerEnvironment(task, options),
        axis_(axis),
        door_(Body("door")),
        door_link_(Body("door_link")),
        lock_(Body("lock_link")),
        knob_(Site(knob)) {}

  [[nodiscard]] virtual LockReach Reach(const Observation& observation) const = 0;

  /// As it is now: the official tasks mean its place after reset, but remember a view of it.
  [[nodiscard]] Eigen::Vector3d LockPosition() const { return BodyPosition(lock_); }

 private:
  void EditModel(const RandVec& p) override { MoveBody(door_, ObjectOf(p)); }

  [[nodiscard]] ObjectPose Object() const override {
    return {SitePosition(knob_), BodyQuaternion(door_link_)};
  }

  Outcome Evaluate(const Observation& observation, const Action& /*action*/) override {
    const double to_target = std::abs(target_[axis_] - observation[4 + axis_]);
    const double turned = LongTail(to_target, 0, 0.005, 0.1);
    const LockReach reach = Reach(observation);
    return {2 * reach.share + 8 * turned,
            {.success = to_target <= 0.02,
             .near_object = reach.distance <= 0.05 ? 1.0 : 0.0,
             .grasp_success = observation[3] > 0 ? 1.0 : 0.0,
             .grasp_reward = reach.reward,
             .in_place_reward = turned,
             .obj_to_target = to_target}};
  }

  const int axis_;
  int door_, door_link_, lock_, knob_;
};

}  // namespace metronome::metaworld::tasks::doors
