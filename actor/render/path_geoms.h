#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <vector>

#include "actor/render/episode_path.h"

namespace metronome::render {

/// The hand's path over the first `steps` steps, as things in MuJoCo's abstract scene: a tube in
/// the colour of the head that moved it (HeadColor), and a ball where a head begins.
/// @param steps  in [0, T].
std::vector<mjvGeom> PathGeoms(const EpisodePath& path, std::int32_t steps);

}  // namespace metronome::render
