#pragma once

#include <mujoco/mujoco.h>

namespace metronome::metaworld {

inline constexpr int kPhysicsSteps = 5;  // per control step, 2.5 ms each

/// One control step as the official environment makes it: kPhysicsSteps times mj_step, then
/// mj_forward.
void ControlStep(const mjModel& model, mjData& data);

/// The same to the bit, without the one collision pass of six that repeats another: `data` must be
/// as mj_forward left it, but for mocap poses and controls.
void ControlStepAfterForward(const mjModel& model, mjData& data);

}  // namespace metronome::metaworld
