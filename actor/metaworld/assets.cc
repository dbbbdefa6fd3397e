#include "actor/metaworld/assets.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>

#include "common/process/files.h"
#include "common/process/mutex.h"
#include "common/process/sha256.h"

namespace metronome::metaworld {
namespace {

std::filesystem::path DataFolder() {
  const auto program = std::filesystem::read_symlink("/proc/self/exe");
  return program.parent_path().parent_path() / "share/metronome";
}

/// @param hash  SHA-256, hexadecimal.
void RequireFile(const std::string& assets, const std::string& file, const std::string& hash) {
  const std::string path = assets + "/" + file;
  const bool there = std::filesystem::exists(path);
  if (there && process::Sha256Hex(process::ReadFile(path)) == hash) return;
  throw std::runtime_error("scene file " + path +
                           (there ? " is not that of Meta-World 3.1.1" : " is missing") +
                           ": remove the folder " + assets + " and run deploy/setup");
}

}  // namespace

std::string DefaultAssetsPath() {
  const char* given = std::getenv("METRONOME_ASSETS");
  if (given != nullptr && *given != '\0') return given;
  return DataFolder() / "metaworld";
}

void RequireOfficialScenes(const std::string& assets) {
  static process::Mutex mutex;
  static std::set<std::string> compared METRONOME_GUARDED_BY(mutex);
  const process::MutexLock lock(mutex);
  if (compared.contains(assets)) return;
  std::ifstream list(DataFolder() / "metaworld.sha256");  // as sha256sum writes it
  for (std::string hash, file; std::getline(list >> hash, file);) {
    if (hash != "#") RequireFile(assets, file.substr(file.find_first_not_of(' ')), hash);
  }
  compared.insert(assets);
}

}  // namespace metronome::metaworld
