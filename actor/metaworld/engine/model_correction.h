#pragma once

#include <mujoco/mujoco.h>

#include <string>

namespace metronome::metaworld::engine {

/// MuJoCo 2.2.2 compiles three scenes and one mesh otherwise than 3.3.0, which the official package
/// pins: this gives them 3.3.0's numbers. Does nothing on later engines.
/// @param scene  file of the model, relative to the assets folder.
void CorrectModel(const std::string& scene, mjModel& model);

}  // namespace metronome::metaworld::engine
