#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>

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

/// An error that MuJoCo reports instead of returning (mju_error). The mjData that it was working
/// on must not be used again.
class EngineError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Sets MuJoCo's process-wide hooks, once: errors become EngineError, warnings go to the log
/// (instead of MUJOCO_LOG.TXT), and 2.2.2 gets its weld correction. Thread-safe, idempotent.
void InitialiseEngine();

/// A compiled scene, loaded once a process and shared by all its environments, each of which steps
/// a copy of its own.
class Scene {
 public:
  /// @param assets  folder of the scene files. @param scene  file relative to it.
  /// @throws std::runtime_error naming the file and the remedy. Thread-safe; blocks 0.15-0.35 s
  ///         the first time.
  static std::shared_ptr<Scene> Load(const std::string& assets, const std::string& scene);

  [[nodiscard]] ModelPtr CopyModel() const;
  [[nodiscard]] DataPtr MakeData() const;

  /// The state that `settle` leaves, computed by the first caller and shared with all others.
  /// @param settle  void(const mjModel&, mjData&), starts from mj_resetData; must be the same
  /// function
  ///                for every caller of this scene. Thread-safe.
  template <class Settle>
  const mjData& Settled(const Settle& settle) {
    std::call_once(settled_once_, [&] {
      const ModelPtr model = CopyModel();
      DataPtr data = MakeData();
      settle(*model, *data);
      settled_ = std::move(data);
    });
    return *settled_;
  }

 private:
  explicit Scene(ModelPtr model) : model_(std::move(model)) {}

  ModelPtr model_;
  std::once_flag settled_once_;
  DataPtr settled_;
};

}  // namespace metronome::metaworld::engine
