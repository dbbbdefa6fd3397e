#pragma once

#include "actor/metaworld/sawyer.h"

/// What the two tasks with a stick and a container share.
namespace metronome::metaworld::tasks::tools {

/// A free stick, and a container on two slides; `object_init_` is the container's.
class Stick : public SawyerEnvironment {
 protected:
  /// @param slide_y  of the container after a reset, metres. @param inserted_y  from the
  /// container's handle to what the observation calls its place, metres.
  Stick(const TaskSpec& task, const EnvironmentOptions& options, double slide_y, double inserted_y);

  [[nodiscard]] Eigen::Vector3d HandlePosition() const { return SitePosition(insertion_); }
  /// Of the stick after the reset.
  [[nodiscard]] const Eigen::Vector3d& StickInit() const { return stick_init_; }
  /// Whether both pads press on the stick and it is 1 cm or so (`lift`, metres) above `height`.
  [[nodiscard]] bool Grasped(const Observation& observation, double lift, double height) const;

 private:
  void PlaceObject(const RandVec& placement) final;
  [[nodiscard]] ObjectPose Object() const final;
  [[nodiscard]] ObjectPose SecondObject() const final;
  /// Height of the goal, metres, before the objects are placed.
  [[nodiscard]] virtual double GoalHeight() const = 0;

  const double slide_y_, inserted_y_;
  const int stick_, stick_geom_, container_, insertion_, goal_;
  const int slides_;  // in qpos: x, then y
  Eigen::Vector3d stick_init_ = Eigen::Vector3d::Zero();
};

}  // namespace metronome::metaworld::tasks::tools
