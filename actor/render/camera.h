#pragma once

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

namespace metronome {

/// What --camera may name in a scene: "free" first, then the scene's own cameras.
std::vector<std::string> CameraNames(const mjModel& model);

/// @param name  "free": a view that shows arm, object and goal of `task`; else a camera of the
/// scene.
/// @throws std::invalid_argument for any other name, listing all.
mjvCamera FindCamera(const mjModel& model, const std::string& task, const std::string& name);

}  // namespace metronome
