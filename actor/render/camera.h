#pragma once

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

#include "actor/environment/mujoco_view.h"

namespace metronome::render {

/// Names for --camera in a scene: "free" first, then the scene's own cameras.
std::vector<std::string> CameraNames(const mjModel& model);

/// @param name  "free": as `free` says; else a camera of the scene.
/// @throws std::invalid_argument for any other name, listing all.
mjvCamera FindCamera(const mjModel& model, const environment::CameraView& free,
                     const std::string& name);

}  // namespace metronome::render
