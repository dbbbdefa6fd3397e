#include "actor/render/episode_pictures.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <utility>

#include "actor/render/head_colors.h"
#include "actor/render/path_geoms.h"
#include "actor/render/timeline.h"

namespace metronome::render {
namespace {

constexpr Color kPanel = {0, 0, 0};
constexpr Color kText = {255, 255, 255};
constexpr double kPanelOpacity = 0.6;

std::int32_t Steps(const EpisodePath& path) {
  return static_cast<std::int32_t>(path.points.size()) - 1;
}

std::string OneDecimal(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f", number);
  return text.data();
}

std::string Outcome(const EpisodePath& path) {
  if (!path.outcome.success) return "no success";
  const auto first = std::find_if(path.points.begin(), path.points.end(),
                                  [](const PathPoint& point) { return point.success; });
  return "success at step " + std::to_string(first - path.points.begin());
}

}  // namespace

EpisodePictures::EpisodePictures(const mjModel& model, const mjvCamera& camera,
                                 const EpisodePath& path, Options options)
    : path_(path),
      options_(std::move(options)),
      renderer_(model, camera, options_.size, 2 * path.points.size(), options_.arm_opacity),
      canvas_(renderer_.context()) {}

Image EpisodePictures::Whole(std::int32_t pose_at) {
  DrawScene(pose_at, Steps(path_));
  DrawFoot(pose_at < Steps(path_) ? std::optional(pose_at) : std::nullopt);
  DrawHeadline(options_.task + "   return " + OneDecimal(path_.outcome.episode_return) + "   " +
                   Outcome(path_),
               std::nullopt);
  return renderer_.Read();
}

Image EpisodePictures::Moment(std::int32_t t) {
  const PathPoint& point = path_.points.at(std::size_t(t));
  DrawScene(t, t);
  DrawFoot(t);
  DrawHeadline(options_.task + "   step " + std::to_string(t) + " / " +
                   std::to_string(Steps(path_)) + "   reward " + OneDecimal(point.reward) +
                   (point.success ? "   success" : ""),
               point.head);
  return renderer_.Read();
}

void EpisodePictures::DrawScene(std::int32_t pose_at, std::int32_t path_steps) {
  const int foot = TimelineHeight(canvas_);
  renderer_.Draw(path_.points.at(std::size_t(pose_at)).pose,
                 options_.show_path ? PathGeoms(path_, path_steps) : std::vector<mjvGeom>{},
                 {0, foot, options_.size.width, options_.size.height - foot});
}

void EpisodePictures::DrawFoot(std::optional<std::int32_t> now) const {
  DrawTimeline(canvas_, path_, {0, 0, options_.size.width, TimelineHeight(canvas_)}, now);
}

void EpisodePictures::DrawHeadline(const std::string& text,
                                   std::optional<std::int32_t> head) const {
  const int line = canvas_.LineHeight();
  const int height = 2 * line;
  const int bottom = options_.size.height - height;
  const int middle = bottom + height / 2;
  int left = 0;
  if (head) {
    const Color color = HeadColor(*head, path_.heads);
    const std::string label = "head " + std::to_string(*head);
    const int width = canvas_.Width("head " + std::to_string(path_.heads - 1)) + line;
    canvas_.Fill({0, bottom, width, height}, color);
    canvas_.CentredText(width / 2, middle, label, TextColorOn(color));
    left = width;
  }
  canvas_.Fill({left, bottom, canvas_.Width(text) + line, height}, kPanel, kPanelOpacity);
  canvas_.Text(left + line / 2, middle, text, kText);
}

}  // namespace metronome::render
