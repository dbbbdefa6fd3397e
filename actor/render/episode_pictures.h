#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <string>

#include "actor/render/canvas.h"
#include "actor/render/episode_path.h"
#include "actor/render/image.h"
#include "actor/render/scene_renderer.h"

namespace metronome::render {

/// Pictures of one episode: the scene, a line of text above, the heads' timeline below.
class EpisodePictures {
 public:
  struct Options {
    std::string task;
    ImageSize size;
    bool show_path = true;
    double arm_opacity = 1;
  };

  /// @param model  as the episode's placement left it. @param path  must outlive this.
  /// @throws as SceneRenderer.
  EpisodePictures(const mjModel& model, const mjvCamera& camera, const EpisodePath& path,
                  Options options);

  /// The whole episode at once: all of the path, the scene as after `pose_at` steps, the outcome.
  Image Whole(std::int32_t pose_at);
  /// One moment, after t steps: the path so far, the head that acts, reward and success.
  Image Moment(std::int32_t t);

 private:
  /// Scene and timeline. @param now  as DrawTimeline's.
  void DrawScene(std::int32_t pose_at, std::int32_t path_steps);
  void DrawFoot(std::optional<std::int32_t> now) const;
  void DrawHeadline(const std::string& text, std::optional<std::int32_t> head) const;

  const EpisodePath& path_;
  const Options options_;
  SceneRenderer renderer_;
  const Canvas canvas_;
};

}  // namespace metronome::render
