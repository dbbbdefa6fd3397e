#pragma once

#include <string>

namespace metronome::metaworld {

/// Folder of the official scene files: $METRONOME_ASSETS if set, else ../share/metronome/metaworld
/// beside the running program's folder, which a build links to what deploy/setup unpacks. Not
/// checked for existence. Thread-safe.
std::string DefaultAssetsPath();

}  // namespace metronome::metaworld
