#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/process/mutex.h"

/// MuJoCo, made safe to own: handles, process-wide set-up, loading.
namespace metronome::metaworld::engine {

struct ModelDeleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
struct DataDeleter {
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using ModelPtr = std::unique_ptr<mjModel, ModelDeleter>;
using DataPtr = std::unique_ptr<mjData, DataDeleter>;

/// A scene's model as one environment has it: positions of bodies and sites in their parents are
/// its own to change, all else is the scene's, which must outlive it.
class PlacedModel {
 public:
  explicit PlacedModel(const mjModel& scene)
      : model_(scene),
        body_pos_(scene.body_pos, scene.body_pos + std::ptrdiff_t{3} * scene.nbody),
        site_pos_(scene.site_pos, scene.site_pos + std::ptrdiff_t{3} * scene.nsite) {
    model_.body_pos = body_pos_.data();
    model_.site_pos = site_pos_.data();
  }
  PlacedModel(const PlacedModel&) = delete;
  PlacedModel& operator=(const PlacedModel&) = delete;

  [[nodiscard]] mjModel* get() { return &model_; }
  [[nodiscard]] const mjModel* get() const { return &model_; }
  mjModel* operator->() { return get(); }
  const mjModel* operator->() const { return get(); }
  const mjModel& operator*() const { return model_; }

 private:
  mjModel model_;
  std::vector<mjtNum> body_pos_;  // [nbody, 3]
  std::vector<mjtNum> site_pos_;  // [nsite, 3]
};

/// An error that MuJoCo reports instead of returning (mju_error). The mjData that it was working
/// on must not be used again.
class EngineError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Sets MuJoCo's process-wide hooks, once: errors become EngineError, warnings go to the log
/// (instead of MUJOCO_LOG.TXT), and 2.2.2 gets its weld correction. Thread-safe, idempotent.
void InitialiseEngine();

/// A compiled scene, loaded once a process and shared by all its environments.
class Scene {
 public:
  /// @param assets  folder of the scene files. @param scene  file relative to it.
  /// @throws std::runtime_error naming the file and the remedy. Thread-safe; blocks 0.15-0.35 s
  ///         the first time.
  static std::shared_ptr<Scene> Load(const std::string& assets, const std::string& scene);

  [[nodiscard]] const mjModel& model() const { return *model_; }
  [[nodiscard]] DataPtr MakeData() const;

  /// The state that `settle` leaves, computed by the first caller with `key` and shared with all
  /// others.
  /// @param settle  void(mjData&), starts from mj_resetData; must be the same function for every
  ///                caller with that key. Thread-safe.
  template <class Settle>
  const mjData& Settled(const std::string& key, const Settle& settle) {
    SharedState& state = StateOf(key);
    std::call_once(state.once, [&] {
      DataPtr data = MakeData();
      settle(*data);
      state.data = std::move(data);
    });
    return *state.data;
  }

 private:
  struct SharedState {
    std::once_flag once;
    DataPtr data;
  };

  explicit Scene(ModelPtr model) : model_(std::move(model)) {}
  SharedState& StateOf(const std::string& key);

  ModelPtr model_;
  process::Mutex mutex_;
  std::map<std::string, SharedState> states_ METRONOME_GUARDED_BY(mutex_);
};

}  // namespace metronome::metaworld::engine
