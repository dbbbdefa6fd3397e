#include "actor/metaworld/engine/engine.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "actor/metaworld/engine/looks.h"
#include "actor/metaworld/engine/model_correction.h"
#include "actor/metaworld/engine/weld_correction.h"

namespace metronome::metaworld::engine {
namespace {

// Thrown through MuJoCo's C frames, which carry unwind tables on x86-64.
void ThrowError(const char* message) { throw EngineError(std::string("MuJoCo: ") + message); }

void LogWarning(const char* message) { spdlog::warn("MuJoCo: {}", message); }

// The official environment overwrites what the XML compiled to (metaworld 3.1.1,
// sawyer_xyz_env.py, reset_mocap_welds): anchor and relative position 0, relative quaternion (-1,
// 0, 0, 0), torque scale 5.
void SetWelds(mjModel& model) {
  constexpr std::array<mjtNum, 11> kWeld = {0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 5};
  static_assert(kWeld.size() == mjNEQDATA);
  for (int i = 0; i < model.neq; ++i)
    if (model.eq_type[i] == mjEQ_WELD)
      std::copy(kWeld.begin(), kWeld.end(), model.eq_data + i * mjNEQDATA);
}

/// @param scene  what `path` is in the assets folder.
ModelPtr LoadModel(const std::string& path, const std::string& scene) {
  const char* remedy = "; run deploy/setup (or point METRONOME_ASSETS at metaworld/assets)";
  if (!std::filesystem::exists(path))
    throw std::runtime_error("scene file " + path + " is missing" + remedy);
  std::array<char, 1000> error{};
  ModelPtr model(mj_loadXML(path.c_str(), nullptr, error.data(), error.size()));
  if (!model)
    throw std::runtime_error("cannot load scene file " + path + ": " + error.data() + remedy);
  SetWelds(*model);
  CorrectModel(scene, *model);
  return model;
}

struct LoadedScene {
  std::string file;  // relative to the assets folder
  std::shared_ptr<Scene> scene;
};

struct LoadedScenes {
  process::Mutex mutex;
  std::map<std::string, LoadedScene> by_path METRONOME_GUARDED_BY(mutex);

  static LoadedScenes& OfProcess() {
    static LoadedScenes scenes;
    return scenes;
  }

  /// Path and file of the scene that `model` is a placed one of; both empty if of none. They share
  /// all arrays but the positions.
  std::pair<std::string, std::string> SourceOf(const mjModel& model) {
    const process::MutexLock lock(mutex);
    for (const auto& [path, loaded] : by_path) {
      if (loaded.scene && loaded.scene->model().names == model.names) return {path, loaded.file};
    }
    return {};
  }
};

}  // namespace

void InitialiseEngine() {
  static std::once_flag once;
  std::call_once(once, [] {
    mju_user_error = ThrowError;
    mju_user_warning = LogWarning;
    InstallWeldCorrection();
  });
}

std::shared_ptr<Scene> Scene::Load(const std::string& assets, const std::string& scene) {
  LoadedScenes& all = LoadedScenes::OfProcess();
  InitialiseEngine();
  const std::string path = assets + "/" + scene;
  const process::MutexLock lock(all.mutex);
  LoadedScene& loaded = all.by_path[path];
  if (!loaded.scene) {
    loaded = {scene, std::shared_ptr<Scene>(new Scene(WithoutLooks(LoadModel(path, scene))))};
  }
  return loaded.scene;
}

ModelPtr CopyToDraw(const mjModel& model) {
  const auto [path, file] = LoadedScenes::OfProcess().SourceOf(model);
  if (path.empty()) return ModelPtr(mj_copyModel(nullptr, &model));
  ModelPtr drawn = LoadModel(path, file);
  std::copy_n(model.body_pos, std::ptrdiff_t{3} * model.nbody, drawn->body_pos);
  std::copy_n(model.site_pos, std::ptrdiff_t{3} * model.nsite, drawn->site_pos);
  return drawn;
}

Scene::SharedState& Scene::StateOf(const std::string& key) {
  const process::MutexLock lock(mutex_);
  return states_[key];  // a map's elements stay where they are
}

DataPtr Scene::MakeData() const { return DataPtr(mj_makeData(model_.get())); }

}  // namespace metronome::metaworld::engine
