#pragma once

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

#include "actor/metaworld/engine/engine.h"
#include "actor/render/episode_path.h"
#include "actor/render/image.h"
#include "actor/render/offscreen_gl.h"

namespace metronome::render {

/// Draws poses of one scene by MuJoCo's own renderer, off-screen. Works on copies alone: of the
/// model, and of mjData a blank one of its own. Bound to the thread that made it.
class SceneRenderer {
 public:
  /// @param model   as the placement left it. @param camera  see FindCamera.
  /// @param size    of everything drawn, pixels. @param extra  most geoms that Draw is ever given.
  /// @param arm_opacity  of what moves with the robot, 0 to 1.
  /// @throws GraphicsError without OpenGL, metaworld::EngineError where MuJoCo cannot use it (a
  /// size
  ///         that is too large, say).
  SceneRenderer(const mjModel& model, const mjvCamera& camera, ImageSize size, std::size_t extra,
                double arm_opacity);
  ~SceneRenderer();
  SceneRenderer(const SceneRenderer&) = delete;
  SceneRenderer& operator=(const SceneRenderer&) = delete;

  /// The scene in `pose`, with `geoms` in it, into a part of the image.
  void Draw(const Pose& pose, const std::vector<mjvGeom>& geoms, const mjrRect& part);

  [[nodiscard]] const mjrContext& context() const { return context_; }  // for what lies on top
  [[nodiscard]] Image Read() const;                                     // what has been drawn

 private:
  void Place(const Pose& pose);

  const OffscreenGl gl_;  // outlives what is made in it
  const ImageSize size_;
  metaworld::engine::ModelPtr model_;
  metaworld::engine::DataPtr data_;
  mjvCamera camera_;
  mjvOption option_{};
  mjvScene scene_{};
  mjrContext context_{};
};

}  // namespace metronome::render
