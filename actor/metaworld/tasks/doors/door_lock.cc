#include "actor/metaworld/tasks/doors/doors.h"
#include "actor/metaworld/tasks/doors/lock.h"

/// Turn a door's lock downwards. As metaworld 3.1.1 has it: envs/sawyer_door_lock_v3.py.
namespace metronome::metaworld::tasks::doors {
namespace {

class DoorLock final : public Lock {
 public:
  DoorLock(const TaskSpec& task, const EnvironmentOptions& options)
      : Lock(task, options, "lockStartLock", 2) {}

 private:
  void PlaceObject(const RandVec& /*p*/) override {
    Substeps();
    object_init_ = LockPosition();
    target_ = object_init_ + Eigen::Vector3d(0, -0.04, -0.1);
  }

  [[nodiscard]] LockReach Reach(const Observation& observation) const override {
    const double distance = ReachNorm(At3(observation.data() + 4, 0) - LeftPad());
    // The margin is meant to be the distance after reset, but is that of now.
    const double near = LongTail(distance, 0, 0.01, distance);
    return {distance, near, Hamacher(observation[3], near).value()};
  }
};

}  // namespace

TaskSpec DoorLockTask() {
  return {.name = "door-lock",
          .family = "doors",
          .scene = "sawyer_xyz/sawyer_door_lock.xml",
          .success = "the lock's knob within 2 cm of the goal's height",
          .expert = {1.0, 1.0, 3427},
          .placement_size = 3,
          .low = {-0.1, 0.8, 0.15},
          .high = {0.1, 0.85, 0.15},
          .goal_box = HandBox(-0.15),
          .hand = {.initial = {0, 0.6F, 0.2F}, .low = {-0.5, 0.4, -0.15}, .settles_alike = false},
          .view = {{0.02, 0.68, 0.17}, 0.9, 140, -20},
          .make = Make<DoorLock>};
}

}  // namespace metronome::metaworld::tasks::doors
