#pragma once

#include "actor/metaworld/sawyer.h"

/// What the tasks with a handle that slides up and down share.
namespace metronome::metaworld::tasks::handles {

/// A box with a handle: official `obj_init_pos` is the box.
class Handle : public SawyerEnvironment {
 protected:
  /// @param handle, goal  sites. @param slide  of the handle after a reset, metres.
  Handle(const TaskSpec& task, const EnvironmentOptions& options, const char* handle,
         const char* goal, double slide);

  void PlaceObject(const RandVec& placement) override;
  [[nodiscard]] Eigen::Vector3d HandlePosition() const { return SitePosition(handle_); }

 private:
  void EditModel(const RandVec& placement) override { MoveBody(box_, ObjectOf(placement)); }
  [[nodiscard]] ObjectPose Object() const override { return {.position = HandlePosition()}; }

  const int box_, handle_, goal_;
  const double slide_;
};

/// A handle to be pressed down; handle-press and handle-press-side differ in their scenes alone.
class HandlePress final : public Handle {
 public:
  HandlePress(const TaskSpec& task, const EnvironmentOptions& options);

 private:
  void PlaceObject(const RandVec& placement) override;
  Outcome Evaluate(const Observation& observation, const Action& action) override;

  Eigen::Vector3d handle_init_ = Eigen::Vector3d::Zero();
};

/// A handle to be pulled up.
class HandlePull : public Handle {
 protected:
  /// @param success  its distance, metres.
  HandlePull(const TaskSpec& task, const EnvironmentOptions& options, const char* handle,
             const CagingShape& caging, double success);

 private:
  /// How far `place` is from the target in this task's measure, metres.
  [[nodiscard]] virtual double ToTarget(const Eigen::Vector3d& place) const = 0;
  /// Whether the handle, now at `place`, has left its place after the reset.
  [[nodiscard]] virtual bool Moved(const Eigen::Vector3d& place) const = 0;
  Outcome Evaluate(const Observation& observation, const Action& action) override;

  const CagingShape caging_;
  const double success_;
};

}  // namespace metronome::metaworld::tasks::handles
