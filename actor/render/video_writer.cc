#include "actor/render/video_writer.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <vector>

#include "common/process/files.h"
#include "common/text/number_text.h"

namespace metronome::render {
namespace {

constexpr const char* kEncoder = "ffmpeg";

std::string NameOf(int descriptor) { return "/proc/self/fd/" + std::to_string(descriptor); }

constexpr int kUnknownEnd = -1;    // no exit status: somebody else collected it
constexpr int kEncoderOutput = 3;  // ffmpeg's descriptor of the video

/// Raw frames in; H.264 that every player takes, colours as in high-definition television out.
std::vector<std::string> EncoderCommand(ImageSize size, double rate) {
  const std::string dimensions = std::to_string(size.width) + "x" + std::to_string(size.height);
  return {kEncoder,
          "-hide_banner",
          "-nostdin",
          "-loglevel",
          "error",
          "-y",
          "-f",
          "rawvideo",
          "-pixel_format",
          "rgb24",
          "-video_size",
          dimensions,
          "-framerate",
          text::FormatNumber(rate),
          "-i",
          "pipe:0",
          "-c:v",
          "libx264",
          "-crf",
          "18",
          "-vf",
          "scale=out_color_matrix=bt709:out_range=tv",
          "-pix_fmt",
          "yuv420p",
          "-colorspace",
          "bt709",
          "-color_primaries",
          "bt709",
          "-color_trc",
          "bt709",
          "-movflags",
          "+faststart",
          "-f",
          "mp4",
          NameOf(kEncoderOutput)};
}

void Check(int error, const char* what) {
  if (error != 0) throw std::system_error(error, std::generic_category(), what);
}

/// Runs `command` with `input` as its standard input, what it says going to `said`, and `output` as
/// its descriptor kEncoderOutput.
pid_t Spawn(std::vector<std::string> command, int input, int said, int output) {
  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  Check(posix_spawn_file_actions_init(&files), "posix_spawn");
  Check(posix_spawnattr_init(&attributes), "posix_spawn");
  posix_spawn_file_actions_adddup2(&files, input, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, said, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, said, STDERR_FILENO);
  posix_spawn_file_actions_adddup2(&files, output, kEncoderOutput);
  // A write that fails ends it: its exit status does not tell of each.
  sigset_t of_writing;
  sigemptyset(&of_writing);
  sigaddset(&of_writing, SIGPIPE);
  sigaddset(&of_writing, SIGXFSZ);
  posix_spawnattr_setsigdefault(&attributes, &of_writing);
  sigset_t none;  // those that this process serves in a thread are blocked in it
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  // A session of its own: whether a terminal's Ctrl-C ends a render is for this process to say.
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSID);
  std::vector<char*> words;
  words.reserve(command.size() + 1);
  for (std::string& word : command) words.push_back(word.data());
  words.push_back(nullptr);
  pid_t child = -1;
  const int error = posix_spawnp(&child, words[0], &files, &attributes, words.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  Check(error, "cannot start ffmpeg");
  return child;
}

bool OnPath(const char* program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (access((std::filesystem::path(folder) / program).c_str(), X_OK) == 0) return true;
  }
  return false;
}

}  // namespace

VideoWriter::MemoryFile::MemoryFile(const char* what) : fd_(memfd_create(what, MFD_CLOEXEC)) {
  if (fd_ < 0) Check(errno, "cannot make a file in memory");
}

VideoWriter::MemoryFile::~MemoryFile() { close(fd_); }

std::string VideoWriter::MemoryFile::Content() const { return process::ReadFile(NameOf(fd_)); }

void VideoWriter::RequireEncoder() {
  if (OnPath(kEncoder)) return;
  throw std::runtime_error(
      "a video needs the program ffmpeg, which is not there: run deploy/setup --video, or install "
      "Debian's package ffmpeg (a .png needs neither)");
}

VideoWriter::VideoWriter(const std::string& path, ImageSize size, double frames_per_second)
    : path_(process::FileToReplace(path)) {
  // A frame for an ffmpeg that has ended is an error to report, not the end of this process.
  std::signal(SIGPIPE, SIG_IGN);
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) Check(errno, "cannot make a pipe");
  try {
    ffmpeg_ = Spawn(EncoderCommand(size, frames_per_second), ends[0], complaints_.descriptor(),
                    video_.descriptor());
  } catch (...) {
    close(ends[0]);
    close(ends[1]);
    throw;
  }
  close(ends[0]);
  input_ = ends[1];
}

VideoWriter::~VideoWriter() {
  if (ffmpeg_ > 0) {
    kill(ffmpeg_, SIGKILL);
    Wait();
  }
}

void VideoWriter::Add(const Image& frame) {
  std::string_view rest(reinterpret_cast<const char*>(frame.rgb.data()), frame.rgb.size());
  while (!rest.empty()) {
    const ssize_t written = write(input_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) Fail();
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
}

void VideoWriter::Finish() {
  const int status = Wait();
  if (status == 128 + SIGXFSZ) {
    throw std::runtime_error("cannot write " + path_ + ": larger than files may be (ulimit -f)");
  }
  if (status != 0) Fail();
  process::WriteFileAtomically(path_, video_.Content());
}

int VideoWriter::Wait() {
  if (input_ >= 0) close(input_);
  input_ = -1;
  int status = 0;
  pid_t ended = -1;
  do ended = waitpid(ffmpeg_, &status, 0);
  while (ended < 0 && errno == EINTR);
  ffmpeg_ = -1;
  if (ended < 0) return kUnknownEnd;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

void VideoWriter::Fail() {
  if (ffmpeg_ > 0) Wait();
  const std::string words = complaints_.Content();
  throw std::runtime_error(
      "ffmpeg could not write " + path_ +
      (words.empty() ? "" : ": " + words.substr(0, words.find_last_not_of('\n') + 1)));
}

}  // namespace metronome::render
