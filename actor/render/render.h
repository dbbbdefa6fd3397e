#pragma once

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>

#include "actor/environment/registry.h"
#include "actor/render/image.h"

namespace metronome::render {

struct RenderOptions {
  std::string checkpoint;
  std::string task;  // any accepted spelling; empty: the checkpoint's
  std::uint64_t seed = 1;
  std::uint64_t episode = 0;          // of those that `evaluate` plays with this seed
  std::string placements = "random";  // random | fixed | mt1
  std::string out;                    // .png or .mp4; empty: no picture
  std::string csv;                    // file for the path's numbers; empty: none
  std::string size;                   // "WIDTHxHEIGHT"; empty: 1280x960, videos 640x480
  std::string camera = "free";
  bool path = true;                   // draw the hand's path
  std::optional<double> arm_opacity;  // 0 to 1; none: 0.4, videos 1
  std::optional<std::int32_t> step;   // .png: the pose drawn, up to the last; none: the last
  std::int32_t every = 2;             // .mp4: a frame every so many steps
  double speed = 1;                   // .mp4: times real time
};

/// "WIDTHxHEIGHT" in pixels, each from 160 to 4096.
/// @throws std::invalid_argument naming what is wrong.
ImageSize ParseImageSize(const std::string& text);

/// `metronome-actor render`: a picture or a video of one episode under the deterministic policy,
/// the hand's path coloured by head, and its numbers as CSV. What was played goes to `out` in one
/// line, what is otherwise than in training is a warning on `err`.
/// @return exit status: 0; 1 where checkpoint, scene, OpenGL, ffmpeg or the files cannot be used; 2
///         for bad options. Files are whole or not there.
int RunRender(const RenderOptions& options, const environment::EnvironmentRegistry& registry,
              std::ostream& out, std::ostream& err);

}  // namespace metronome::render
