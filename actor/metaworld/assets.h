#pragma once

#include <string>

namespace metronome::metaworld {

/// Folder of the official scene files: METRONOME_ASSETS where that is set, else what set-up or an
/// installation has put beside the program.
std::string DefaultAssetsPath();

/// Compares the scene files in `assets` with the list of their hashes beside the program (where
/// there is none, with nothing), once a process. Thread-safe; takes 0.1 s the first time.
/// @throws std::runtime_error naming the first file that is missing or another one, and the remedy.
void RequireOfficialScenes(const std::string& assets);

}  // namespace metronome::metaworld
