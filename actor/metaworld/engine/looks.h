#pragma once

#include <mujoco/mujoco.h>

#include "actor/metaworld/engine/engine.h"

/// What of a scene is only seen: nine tenths of its memory, and actors draw nothing.
namespace metronome::metaworld::engine {

/// The model without textures and without what meshes have besides their vertices and hulls.
/// Physics reads none of it, so its bits are the same; every index stays. The scene's rays, signed
/// distances and contacts of multiple points between meshes must not be asked for.
/// @return a model of its own, or `model` itself if this engine lays models out otherwise.
ModelPtr WithoutLooks(ModelPtr model);

/// A model to draw: that of the scene's file, placed as `model` is. A model that no Scene has
/// loaded is copied as it is. Blocks for as long as Scene::Load does.
ModelPtr CopyToDraw(const mjModel& model);

}  // namespace metronome::metaworld::engine
