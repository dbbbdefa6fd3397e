#pragma once

#include <optional>

#include "actor/metaworld/sawyer.h"

/// What the tasks with a free object to be pushed share.
namespace metronome::metaworld::tasks::pushing {

inline constexpr CagingShape kPuckCaging = {
    .object_radius = 0.015, .pad_success = 0.05, .xz_threshold = 0.005};
inline constexpr double kNear = 0.05;  // metres from the goal, where most tasks pay the full reward

struct PushedSettings {
  const char* body = "obj";
  std::optional<double> height = std::nullopt;  // that it is placed at; unset: as it has settled
  double success;                               // distance that counts, metres
  bool lifts = true;  // whether a grasp counts only of an object that is lifted
};

/// A moment of an episode as the reward sees it; metres.
struct Moment {
  Eigen::Vector3d object, target;
  double opening;  // of the gripper, 0..1
  double tcp_to_object, to_target;
};

struct Reward {
  Scalar total, grasp;
  double in_place;
};

class PushedObject : public SawyerEnvironment {
 protected:
  PushedObject(const TaskSpec& task, const EnvironmentOptions& options,
               const PushedSettings& settings);

  [[nodiscard]] int Pushed() const { return object_; }  // body
  [[nodiscard]] ObjectPose Object() const override;

 private:
  /// @param height  that the object is placed at, metres: that of most goals, too.
  [[nodiscard]] virtual Eigen::Vector3d Goal(const RandVec& placement, double height) const {
    return {placement[3], placement[4], height};
  }
  /// The goal for an object that is now at `object`.
  [[nodiscard]] virtual Eigen::Vector3d GoalFor(const Eigen::Vector3d& /*object*/) const {
    return target_;
  }
  /// @param gripper  action[3] as given.
  [[nodiscard]] virtual Reward RewardOf(const Moment& now, float gripper) const = 0;

  void PlaceObject(const RandVec& placement) final;
  Outcome Evaluate(const Observation& observation, const Action& action) final;

  const PushedSettings settings_;
  const int object_, geom_, goal_;
};

}  // namespace metronome::metaworld::tasks::pushing
