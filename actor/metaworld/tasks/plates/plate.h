#pragma once

#include "actor/metaworld/sawyer.h"

/// What the four tasks with a plate share.
namespace metronome::metaworld::tasks::plates {

struct PlateSettings {
  double x, y;   // where a reset puts the two slides, metres
  double slack;  // that the reward's margins fall short of the first distances, metres
};

/// A plate on two slides. `object_init_` is the placement's first half, also where the task puts
/// the plate elsewhere: as official.
class Plate : public SawyerEnvironment {
 protected:
  Plate(const TaskSpec& task, const EnvironmentOptions& options, const PlateSettings& settings);

  [[nodiscard]] int GoalFrame() const { return frame_; }  // body

 private:
  void PlaceObject(const RandVec& placement) override;
  [[nodiscard]] ObjectPose Object() const override;
  Outcome Evaluate(const Observation& observation, const Action& action) override;
  /// Away from the goal. @param tcp_to_plate  metres. @param grasp, in_place  in [0, 1].
  [[nodiscard]] virtual double Reward(double tcp_to_plate, double grasp, double in_place) const;

  const PlateSettings settings_;
  const int plate_, frame_, goal_;
  const int slides_;  // in qpos: x, then y
};

}  // namespace metronome::metaworld::tasks::plates
