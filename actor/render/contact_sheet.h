#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "actor/environment/registry.h"
#include "actor/render/image.h"

namespace metronome::render {

/// One picture of many environments: each at the start of an episode, with its name, in rows from
/// left to right.
/// @param names    of environments in MuJoCo. @param columns  at least 1. @param tile  of each.
/// @throws as SceneRenderer and EnvironmentRegistry::Make, std::invalid_argument for one that
/// cannot
///         be drawn.
Image ContactSheet(const environment::EnvironmentRegistry& registry,
                   const std::vector<std::string>& names, int columns, ImageSize tile);

/// `metronome-actor tasks --picture`: of all environments of the registry.
/// @return exit status: 0; 1 where scenes, OpenGL or the file cannot be used.
int RunContactSheet(const std::string& path, const environment::EnvironmentRegistry& registry,
                    std::ostream& out, std::ostream& err);

}  // namespace metronome::render
