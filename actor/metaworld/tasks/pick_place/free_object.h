#pragma once

#include <Eigen/Core>
#include <optional>

#include "actor/metaworld/sawyer.h"

namespace metronome::metaworld::tasks::pick_place {

/// An object that lies free, for the gripper to carry to the goal: what most tasks of this family
/// share.
class FreeObject : public SawyerEnvironment {
 protected:
  /// What the rewards ask about a step. Distances in metres.
  struct Situation {
    Eigen::Vector3d object;  // as observed
    double opening;          // of the gripper, 0 to 1
    double to_object;        // from between the finger tips
    double to_target;        // from the object
  };

  struct Terms {
    Scalar reward, grasp;
    double in_place;
    bool grasped;
    double success_within = 0.07;  // metres; beyond the 0.05 that the full reward needs
    double near_within = 0.03;
  };

  /// @param mark  site that shows the goal in pictures; null: none.
  FreeObject(const TaskSpec& task, const EnvironmentOptions& options, const char* body,
             const char* mark);

  /// Object and goal where the placement says.
  void PlaceObject(const RandVec& p) override { Place(ObjectOf(p), GoalOf(p)); }
  [[nodiscard]] ObjectPose Object() const override {
    return {BodyPosition(object_), BodyQuaternion(object_)};
  }

  void Place(const Eigen::Vector3d& object, const Eigen::Vector3d& target);
  void SetTarget(const Eigen::Vector3d& target);  // with its mark

  [[nodiscard]] Situation See(const Observation& observation) const;
  /// How near the object is to the target, 1 within `within`, by the distance that it began at.
  [[nodiscard]] double InPlace(const Situation& now, double within = 0.05) const;
  /// Whether the gripper is open and the object is higher than it began, by more than `height`.
  [[nodiscard]] bool Lifted(const Situation& now, double height) const {
    return now.opening > 0 && now.object.z() - height > object_init_.z();
  }
  /// The reward is 10 in place of the terms' where the object is nearer to the target than 0.05.
  [[nodiscard]] static Outcome Conclude(const Situation& now, const Terms& terms);

  const int object_;

 private:
  const std::optional<int> mark_;
};

/// The object is a block of one geom, observed with that geom's rotation.
class Block : public FreeObject {
 protected:
  Block(const TaskSpec& task, const EnvironmentOptions& options, const char* mark)
      : FreeObject(task, options, "obj", mark), geom_(Geom("objGeom")) {}

  [[nodiscard]] ObjectPose Object() const override {
    return {BodyPosition(object_), GeomQuaternion(geom_)};
  }
  /// Both pads press on the block, which is in the air.
  [[nodiscard]] bool Held(const Situation& now) const {
    return Pinched(geom_) && Lifted(now, 0.02);
  }

 private:
  const int geom_;
};

}  // namespace metronome::metaworld::tasks::pick_place
