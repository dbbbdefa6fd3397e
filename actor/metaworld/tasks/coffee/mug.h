#pragma once

#include "actor/metaworld/sawyer.h"

/// What tasks with the mug share.
namespace metronome::metaworld::tasks::coffee {

inline constexpr int kMugQpos = 0;  // the mug's joint comes before the arm's in this scene
/// The official reset means to stop the mug, but takes these velocities for its: they belong to
/// four joints of the arm and the fingers. The mug's are kept.
inline constexpr int kStoppedQvel = 9;

/// From the middle of the machine to the place of a mug in it, metres.
inline const Eigen::Vector3d kToMug(0, -0.22, 0);

struct MugSettings {
  /// Which half of a placement is in the machine: the mug's or the goal's.
  Eigen::Vector3d (*in_machine)(const RandVec& placement);
};

/// The mug, to be moved into the machine or out of it.
class Mug final : public SawyerEnvironment {
 public:
  Mug(const TaskSpec& task, const EnvironmentOptions& options, const MugSettings& settings);

 private:
  void EditModel(const RandVec& p) override {
    MoveBody(machine_, settings_.in_machine(p) - kToMug);
  }
  void PlaceObject(const RandVec& p) override;
  [[nodiscard]] ObjectPose Object() const override {
    return {BodyPosition(mug_), GeomQuaternion(mug_geom_)};
  }
  Outcome Evaluate(const Observation& observation, const Action& action) override;

  const MugSettings& settings_;
  int machine_, mug_, mug_geom_, goal_;
};

}  // namespace metronome::metaworld::tasks::coffee
