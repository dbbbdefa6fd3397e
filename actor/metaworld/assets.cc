#include "actor/metaworld/assets.h"

#include <cstdlib>
#include <filesystem>

namespace metronome::metaworld {

std::string DefaultAssetsPath() {
  const char* given = std::getenv("METRONOME_ASSETS");
  if (given != nullptr && *given != '\0') return given;
  const auto program = std::filesystem::read_symlink("/proc/self/exe");
  return program.parent_path().parent_path() / "share/metronome/metaworld";
}

}  // namespace metronome::metaworld
