#pragma once

#include "actor/metaworld/sawyer.h"

/// What tasks with a door share that turns on its hinge.
namespace metronome::metaworld::tasks::doors {

class Door : public SawyerEnvironment {
 protected:
  /// @param start  angle after a reset, radians. @param goal  seen from the door's origin, metres.
  Door(const TaskSpec& task, const EnvironmentOptions& options, double start,
       const Eigen::Vector3d& goal)
      : SawyerEnvironment(task, options),
        start_(start),
        goal_(goal),
        door_(Body("door")),
        hinge_(Joint("doorjoint")),
        handle_(Geom("handle")),
        goal_mark_(Site("goal")) {}

  /// Radians, negative when open.
  [[nodiscard]] double Angle() const { return data_->qpos[hinge_]; }

 private:
  void EditModel(const RandVec& p) override { MoveBody(door_, ObjectOf(p)); }

  void PlaceObject(const RandVec& p) override {
    object_init_ = ObjectOf(p);
    target_ = object_init_ + goal_;
    MoveSite(goal_mark_, target_);
    SetQpos(hinge_, {start_});
    Stop(hinge_, 1);
    Forward();
  }

  [[nodiscard]] ObjectPose Object() const override {
    return {GeomPosition(handle_), GeomQuaternion(handle_)};
  }

  const double start_;
  const Eigen::Vector3d goal_;
  int door_, hinge_, handle_, goal_mark_;
};

}  // namespace metronome::metaworld::tasks::doors
