#pragma once

#include <sys/types.h>

#include <string>

#include "actor/render/image.h"

namespace metronome {

/// An H.264 video in an MP4 file, made by the program ffmpeg: one frame after another goes down its
/// standard input. Not thread-safe.
class VideoWriter {
 public:
  /// @throws std::runtime_error saying what to install, unless there is an ffmpeg to be run. Cheap.
  static void RequireEncoder();

  /// Starts ffmpeg. @param size  even numbers (H.264 halves colours). @param frames_per_second  >
  /// 0.
  /// @throws std::system_error if it cannot be started, or what is at `path` is no regular file.
  VideoWriter(const std::string& path, ImageSize size, double frames_per_second);
  /// Without Finish: ends ffmpeg and leaves no file.
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  /// @throws std::runtime_error with ffmpeg's words if it does not take the frame.
  void Add(const Image& frame);
  /// Waits for ffmpeg and puts the finished file in its place.
  /// @throws std::runtime_error with ffmpeg's words if it failed; then there is no file.
  void Finish();

 private:
  /// Closes ffmpeg's input and waits. @return its exit status, or 128 + the signal that ended it.
  int Wait();
  [[noreturn]] void Fail();

  const std::string path_;
  const std::string unfinished_;  // beside it, until Finish
  const std::string complaints_;  // what ffmpeg says
  int input_ = -1;
  pid_t ffmpeg_ = -1;
};

}  // namespace metronome
