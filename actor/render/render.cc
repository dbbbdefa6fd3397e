#include "actor/render/render.h"

#include <unistd.h>

#include <filesystem>
#include <optional>
#include <ostream>
#include <stdexcept>

#include "actor/environment/mujoco_view.h"
#include "actor/play/evaluate.h"
#include "actor/play/training_differences.h"
#include "actor/render/camera.h"
#include "actor/render/episode_path.h"
#include "actor/render/episode_pictures.h"
#include "actor/render/video_writer.h"
#include "common/checkpoint/checkpoint.h"
#include "common/process/files.h"
#include "common/text/near_miss.h"
#include "common/text/number_text.h"

namespace metronome::render {
namespace {

constexpr int kLeastSide = 160;  // pixels; text and timeline need some room
constexpr int kMostSide = 4096;  // pixels

enum class Medium { kNone, kPicture, kVideo };

Medium MediumOf(const std::string& path) {
  if (path.empty()) return Medium::kNone;
  const std::string extension = std::filesystem::path(path).extension().string();
  if (extension == ".png") return Medium::kPicture;
  if (extension == ".mp4") return Medium::kVideo;
  throw std::invalid_argument("--out " + path +
                              ": the name must end in .png (a picture) or .mp4 (a "
                              "video)");
}

ImageSize SizeOf(const RenderOptions& options, Medium medium) {
  const bool video = medium == Medium::kVideo;
  if (options.size.empty()) return video ? ImageSize{640, 480} : ImageSize{1280, 960};
  const ImageSize size = ParseImageSize(options.size);
  if (video && (size.width % 2 != 0 || size.height % 2 != 0)) {
    throw std::invalid_argument("--size " + options.size +
                                ": a video's width and height must be even");
  }
  return size;
}

/// In a picture the arm stands still, often before the path.
double ArmOpacity(const RenderOptions& options, Medium medium) {
  const bool fade = medium == Medium::kPicture && options.path;
  return options.arm_opacity.value_or(fade ? 0.4 : 1);
}

/// Before an episode is played in vain.
void RequireWritable(const std::string& path) {
  if (path.empty()) return;
  const std::filesystem::path folder =
      std::filesystem::path(process::FileToReplace(path)).parent_path();
  const std::string named = folder.empty() ? "." : folder.string();
  if (!std::filesystem::is_directory(named)) {
    throw std::runtime_error("cannot write " + path + ": there is no folder " + named);
  }
  if (access(named.c_str(), W_OK) != 0) {
    throw std::runtime_error("cannot write " + path + ": the folder " + named + " is not writable");
  }
}

void RequireValid(const RenderOptions& options) {
  if (options.out.empty() && options.csv.empty()) {
    throw std::invalid_argument(
        "nothing to make: give --out FILE.png, --out FILE.mp4 or --csv FILE");
  }
  if (options.every < 1) throw std::invalid_argument("--every must be at least 1");
  if (!(options.speed > 0)) throw std::invalid_argument("--speed must be above 0");
}

/// @param last  step of the episode.
std::int32_t PoseAt(const RenderOptions& options, std::int32_t last) {
  const std::int32_t step = options.step.value_or(last);
  if (step < 0 || step > last) {
    throw std::invalid_argument("--step " + std::to_string(step) + ": the episode has steps 0 to " +
                                std::to_string(last));
  }
  return step;
}

/// @param rate  steps a second, in real time.
void WriteVideo(const RenderOptions& options, ImageSize size, double rate, std::int32_t last,
                EpisodePictures& pictures) {
  VideoWriter video(options.out, size, rate * options.speed / options.every);
  for (std::int32_t t = 0; t <= last; t += options.every) video.Add(pictures.Moment(t));
  video.Finish();
}

play::EvaluateOptions AsEvaluated(const RenderOptions& options) {
  play::EvaluateOptions evaluate;
  evaluate.checkpoint = options.checkpoint;
  evaluate.task = options.task;
  evaluate.seed = options.seed;
  evaluate.placements = options.placements;
  return evaluate;
}

play::PlayedTask TaskToDraw(const checkpoint::Checkpoint& checkpoint, const RunConfig& config,
                            const environment::EnvironmentRegistry& registry) {
  const auto tasks = play::TasksToPlay(checkpoint, config, registry);
  if (tasks.size() == 1) return tasks.front();
  throw std::invalid_argument("an episode is of one task: name it by --task, of those of " +
                              config.environment().task());
}

void Render(const RenderOptions& options, const environment::EnvironmentRegistry& registry,
            std::ostream& out, std::ostream& err) {
  RequireValid(options);
  const Medium medium = MediumOf(options.out);
  const ImageSize size = SizeOf(options, medium);
  const play::EvaluateOptions evaluate = AsEvaluated(options);
  play::RequireValid(evaluate);
  RequireWritable(options.out);
  RequireWritable(options.csv);
  if (medium == Medium::kVideo) VideoWriter::RequireEncoder();

  const checkpoint::Checkpoint checkpoint = checkpoint::LoadCheckpoint(
      options.checkpoint, [&registry](const auto& name) { return registry.Describe(name); });
  const RunConfig config = play::ConfigToEvaluate(checkpoint, evaluate, registry);
  play::Warn(play::DifferencesFromTraining(checkpoint, evaluate, config), err);
  const RunConfig policy = play::PolicyToEvaluate(checkpoint, config);
  const play::PlayedTask played = TaskToDraw(checkpoint, config, registry);
  const std::string& task = played.name;
  PoseAt(options, config.environment().horizon());
  const auto environment = registry.Make(config.environment(), played.environment);
  const environment::MujocoView* scene = environment->mujoco();
  if (scene == nullptr) {
    throw std::invalid_argument("environment " + task + " cannot be drawn: it is not in MuJoCo");
  }
  const mjvCamera camera = FindCamera(scene->model(), scene->view(), options.camera);
  const EpisodePath path =
      FollowEpisode(policy, checkpoint.state.policy,
                    play::EvaluationSchedule(evaluate, policy, options.episode, played.policy),
                    play::EvaluationStart(evaluate, config, options.episode), *environment);
  const std::int32_t last = path.outcome.length;
  const std::int32_t pose_at = PoseAt(options, last);  // it may have ended early

  if (medium != Medium::kNone) {
    EpisodePictures pictures(scene->model(), camera, path,
                             {task, size, options.path, ArmOpacity(options, medium)});
    if (medium == Medium::kPicture) WritePng(options.out, pictures.Whole(pose_at));
    if (medium == Medium::kVideo) {
      WriteVideo(options, size, scene->steps_per_second(), last, pictures);
    }
  }
  if (!options.csv.empty()) process::WriteFileAtomically(options.csv, Csv(path));
  const bool fixed = config.environment().placements() == PLACEMENTS_FIXED;
  out << task << ", weights version " << checkpoint.state.version << ", "
      << (fixed ? "fixed placement" : "seed " + std::to_string(options.seed)) << ", episode "
      << options.episode << ": return " << text::FormatNumber(path.outcome.episode_return)
      << (path.outcome.success ? ", success" : ", no success") << '\n';
  for (const std::string& written : {options.out, options.csv}) {
    if (!written.empty()) out << "wrote " << written << '\n';
  }
  out << std::flush;
  if (!out) throw std::runtime_error("cannot write the result to standard output");
}

}  // namespace

ImageSize ParseImageSize(const std::string& text) {
  const std::size_t cross = text.find('x');
  const auto width = text::ParseNumber<int>(text.substr(0, cross));
  const auto height =
      text::ParseNumber<int>(cross == std::string::npos ? "" : text.substr(cross + 1));
  const auto fits = [](int side) { return kLeastSide <= side && side <= kMostSide; };
  if (!width || !height || !fits(*width) || !fits(*height)) {
    throw std::invalid_argument("--size " + text + ": must be WIDTHxHEIGHT, each from " +
                                std::to_string(kLeastSide) + " to " + std::to_string(kMostSide) +
                                " pixels, 1280x960 for example");
  }
  return {*width, *height};
}

int RunRender(const RenderOptions& options, const environment::EnvironmentRegistry& registry,
              std::ostream& out, std::ostream& err) {
  try {
    Render(options, registry, out, err);
    return 0;
  } catch (const std::invalid_argument& error) {
    err << "error: " << error.what() << '\n';
    return 2;
  } catch (const std::exception& error) {
    err << "error: " << error.what() << '\n';
    return 1;
  }
}

}  // namespace metronome::render
