#pragma once

#include <string>

namespace metronome::metaworld {

/// Folder of the official scene files: $METRONOME_ASSETS if set, else the place under the source
/// tree where deploy/setup unpacks them. Not checked for existence. Thread-safe.
std::string DefaultAssetsPath();

}  // namespace metronome::metaworld
