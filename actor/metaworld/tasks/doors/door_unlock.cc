#include "actor/metaworld/tasks/doors/doors.h"
#include "actor/metaworld/tasks/doors/lock.h"

/// Turn a door's lock back up. As metaworld 3.1.1 has it: envs/sawyer_door_unlock_v3.py.
namespace metronome::metaworld::tasks::doors {
namespace {

constexpr int kLockQpos = 9;  // its hinge has no name; it follows 7 arm and 2 finger joints
const Eigen::Vector3d kShoulder(0, 0.055, 0.07);  // of the gripper, seen from the hand, metres

class DoorUnlock final : public Lock {
 public:
  DoorUnlock(const TaskSpec& task, const EnvironmentOptions& options)
      : Lock(task, options, "lockStartUnlock", 0) {}

 private:
  void PlaceObject(const RandVec& /*p*/) override {
    SetQpos(kLockQpos, {1.5708});
    Stop(kLockQpos, 1);
    Forward();
    object_init_ = LockPosition();
    target_ = object_init_ + Eigen::Vector3d(0.1, -0.04, 0);
  }

  [[nodiscard]] LockReach Reach(const Observation& observation) const override {
    const Eigen::Vector3d hand = At3(observation.data(), 0);
    const Eigen::Vector3d knob = At3(observation.data() + 4, 0);
    const double distance = ReachNorm(hand + kShoulder - knob);
    const double margin = ReachNorm(tcp_init_ + kShoulder - LockPosition());
    const double ready = LongTail(distance, 0, 0.02, margin);
    return {distance, ready, ready};
  }
};

}  // namespace

TaskSpec DoorUnlockTask() {
  return {.name = "door-unlock",
          .family = "doors",
          .scene = "sawyer_xyz/sawyer_door_lock.xml",
          .success = "the lock's knob within 2 cm of the goal from left to right",
          .expert = {1.0, 0.7, 3400},
          .placement_size = 3,
          .low = {-0.1, 0.8, 0.15},
          .high = {0.1, 0.85, 0.15},
          .goal_box = Box{{0, 0.64, 0.21}, {0.2, 0.7, 0.2111}},
          .hand = {.initial = {0, 0.6F, 0.2F}, .low = {-0.5, 0.4, -0.15}, .settles_alike = false},
          .view = {{0.02, 0.68, 0.17}, 0.9, 140, -20},
          .make = Make<DoorUnlock>};
}

}  // namespace metronome::metaworld::tasks::doors
