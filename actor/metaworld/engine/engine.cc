#include "actor/metaworld/engine/engine.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>

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
  static process::Mutex mutex;
  static std::map<std::string, std::shared_ptr<Scene>> scenes METRONOME_GUARDED_BY(mutex);
  InitialiseEngine();
  const std::string path = assets + "/" + scene;
  const process::MutexLock lock(mutex);
  auto& entry = scenes[path];
  if (!entry) entry = std::shared_ptr<Scene>(new Scene(LoadModel(path, scene)));
  return entry;
}

Scene::SharedState& Scene::StateOf(const std::string& key) {
  const process::MutexLock lock(mutex_);
  return states_[key];  // a map's elements stay where they are
}

DataPtr Scene::MakeData() const { return DataPtr(mj_makeData(model_.get())); }

}  // namespace metronome::metaworld::engine
