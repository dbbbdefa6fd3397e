#include "actor/metaworld/assets.h"

#include <cstdlib>

// CMakeLists.txt defines METRONOME_SOURCE_DIR.
namespace metronome::metaworld {

std::string DefaultAssetsPath() {
  const char* given = std::getenv("METRONOME_ASSETS");
  if (given != nullptr && *given != '\0') return given;
  return METRONOME_SOURCE_DIR "/.cache/metaworld-3.1.1/assets";
}

}  // namespace metronome::metaworld
