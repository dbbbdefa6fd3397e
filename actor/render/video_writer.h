#pragma once

#include <sys/types.h>

#include <string>

#include "actor/render/image.h"

namespace metronome::render {

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
  /// Without Finish: ends ffmpeg and leaves no file. Nor is one left by a process that is killed;
  /// ffmpeg then ends with its input.
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  /// @throws std::runtime_error with ffmpeg's words if it does not take the frame.
  void Add(const Image& frame);
  /// Waits for ffmpeg and puts the finished file in its place.
  /// @throws std::runtime_error with ffmpeg's words if it failed, std::system_error if the file
  ///         cannot be written; then there is no file.
  void Finish();

 private:
  /// A file without a name, gone with the last process that has it open.
  class MemoryFile {
   public:
    explicit MemoryFile(const char* what);
    ~MemoryFile();
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;
    [[nodiscard]] int descriptor() const { return fd_; }
    [[nodiscard]] std::string Content() const;

   private:
    int fd_;
  };

  /// Closes ffmpeg's input and waits. @return its exit status, or 128 + the signal that ended it.
  int Wait();
  [[noreturn]] void Fail();

  const std::string path_;
  const MemoryFile video_{"video"};
  const MemoryFile complaints_{"ffmpeg"};  // what it says
  int input_ = -1;
  pid_t ffmpeg_ = -1;
};

}  // namespace metronome::render
