#pragma once

#include <mujoco/mujoco.h>

#include <vector>

#include "actor/metaworld/engine/collision_pairs.h"

namespace metronome::metaworld::engine {

inline constexpr int kPhysicsSteps = 5;  // per control step, 2.5 ms each

/// The engine's mj_step and mj_forward for the scenes of this project, the same to the bit in all
/// that physics, observations and rewards depend on, without what nothing here reads: poses of
/// fixed bodies over and over, of purely visual geoms, of cameras and lights (a renderer calls
/// mj_forward itself), the general search for collisions (collision_pairs.h), and the one collision
/// pass of six that repeats another. Not thread-safe; one per environment.
class ControlStepper {
 public:
  /// @param model  must outlive this. Body and site positions may change later; call Begin then.
  /// @throws std::logic_error for a scene with what these shortcuts do not know: sensors, another
  ///         integrator than Euler's, or what CollisionPairs refuses.
  explicit ControlStepper(const mjModel& model);

  /// Keeps the pose of `geom` up to date, too, though it is only seen.
  void Watch(int geom);

  /// mj_step's substeps from a state of whatever origin: fixed bodies are placed anew first.
  void Begin(mjData& data) const;
  /// As Begin, but leaves qpos to the next step, which normalises its quaternions (on 2.2.2 once
  /// and twice are not the same bits): for a state that another model of this scene, with its fixed
  /// bodies elsewhere, has come to.
  void PlaceFixedBodies(mjData& data) const;
  /// `count` times mj_step. Begin, or mj_forward, once before.
  void Steps(mjData& data, int count);

  /// One control step as the official environment makes it: kPhysicsSteps times mj_step, then
  /// mj_forward.
  void ControlStep(mjData& data);
  /// The same where `data` is as mj_forward left it, but for mocap poses and controls.
  void ControlStepAfterForward(mjData& data);

 private:
  void Kinematics(mjData& data) const;
  void Forward(mjData& data);
  void Step(mjData& data);
  void StepAfterForward(mjData& data) const;

  const mjModel& model_;
  mjModel bodies_only_;     // the model without geoms and sites
  std::vector<int> geoms_;  // that move and collide, or are watched
  std::vector<int> sites_;  // that move
  CollisionPairs pairs_;
};

}  // namespace metronome::metaworld::engine
