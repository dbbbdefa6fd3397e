#include "actor/render/timeline.h"

#include <algorithm>
#include <string>

#include "actor/render/head_colors.h"

namespace metronome::render {
namespace {

constexpr Color kPaper = {255, 255, 255};
constexpr Color kInk = {0, 0, 0};

/// Where on the image a step is.
struct Scale {
  mjrRect bar;
  std::int32_t steps;

  [[nodiscard]] int X(std::int32_t step) const {
    return bar.left + static_cast<int>(std::int64_t{step} * bar.width / steps);
  }
};

void DrawColors(const Canvas& canvas, const Scale& scale, const std::vector<HeadTurn>& runs,
                std::int32_t heads) {
  for (const HeadTurn& run : runs) {
    const int left = scale.X(run.begin);
    canvas.Fill({left, scale.bar.bottom, scale.X(run.end) - left, scale.bar.height},
                HeadColor(run.head, heads));
  }
}

/// Each head's number in its stretch, as many as there is room for.
void DrawNumbers(const Canvas& canvas, const Scale& scale, const std::vector<HeadTurn>& runs,
                 std::int32_t heads) {
  int free_from = scale.bar.left;
  for (const HeadTurn& run : runs) {
    const std::string number = std::to_string(run.head);
    const int x = (scale.X(run.begin) + scale.X(run.end)) / 2;
    const int half = canvas.Width(number) / 2;
    if (x - half < free_from || x + half > scale.X(scale.steps)) continue;
    canvas.CentredText(x, scale.bar.bottom + scale.bar.height / 2, number,
                       TextColorOn(HeadColor(run.head, heads)));
    free_from = x + half + canvas.LineHeight() / 2;
  }
}

/// The steps at which heads change, as many as there is room for; the last one always.
void DrawSteps(const Canvas& canvas, const Scale& scale, const std::vector<HeadTurn>& runs, int y) {
  const int gap = canvas.LineHeight();
  const std::string last = std::to_string(scale.steps);
  const int limit = scale.X(scale.steps) - canvas.Width(last) / 2 - gap;
  int free_from = 0;
  for (const HeadTurn& run : runs) {
    const std::string step = std::to_string(run.begin);
    const int x = scale.X(run.begin);
    const int half = canvas.Width(step) / 2;
    if (x - half < free_from || x + half > limit) continue;
    canvas.CentredText(x, y, step, kInk);
    free_from = x + half + gap;
  }
  canvas.CentredText(scale.X(scale.steps), y, last, kInk);
}

void DrawMark(const Canvas& canvas, const Scale& scale, std::int32_t now) {
  const int half = std::max(1, canvas.LineHeight() / 10);
  const int over = canvas.LineHeight() / 4;
  const mjrRect mark = {scale.X(now) - half, scale.bar.bottom - over, 2 * half,
                        scale.bar.height + 2 * over};
  canvas.Fill({mark.left - half, mark.bottom, mark.width + 2 * half, mark.height}, kPaper);
  canvas.Fill(mark, kInk);
}

}  // namespace

std::vector<HeadTurn> HeadTurns(const EpisodePath& path) {
  std::vector<HeadTurn> runs;
  for (std::int32_t t = 1; t < static_cast<std::int32_t>(path.points.size()); ++t) {
    const std::int32_t head = path.points[std::size_t(t)].head;
    if (runs.empty() || runs.back().head != head) runs.push_back({head, t - 1, t});
    runs.back().end = t;
  }
  return runs;
}

int TimelineHeight(const Canvas& canvas) { return canvas.LineHeight() * 7 / 2; }

void DrawTimeline(const Canvas& canvas, const EpisodePath& path, const mjrRect& area,
                  std::optional<std::int32_t> now) {
  const int line = canvas.LineHeight();
  const int captions = line + std::max(canvas.Width("head"), canvas.Width("step"));
  const Scale scale = {{area.left + captions + line, area.bottom + line * 7 / 4,
                        area.width - captions - 3 * line, line * 5 / 4},
                       static_cast<std::int32_t>(path.points.size()) - 1};
  const std::vector<HeadTurn> runs = HeadTurns(path);
  const int head_line = scale.bar.bottom + scale.bar.height / 2;
  const int step_line = area.bottom + line;
  canvas.Fill(area, kPaper);
  canvas.Text(area.left + line / 2, head_line, "head", kInk);
  canvas.Text(area.left + line / 2, step_line, "step", kInk);
  DrawColors(canvas, scale, runs, path.heads);
  DrawNumbers(canvas, scale, runs, path.heads);
  DrawSteps(canvas, scale, runs, step_line);
  if (now) DrawMark(canvas, scale, *now);
}

}  // namespace metronome::render
