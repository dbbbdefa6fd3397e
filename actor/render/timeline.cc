#include "actor/render/timeline.h"

#include <algorithm>
#include <string>

#include "actor/render/head_colors.h"

namespace metronome {
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

void DrawRun(const Canvas& canvas, const Scale& scale, const HeadRun& run, std::int32_t heads) {
  const int left = scale.X(run.begin);
  const mjrRect stretch = {left, scale.bar.bottom, scale.X(run.end) - left, scale.bar.height};
  const Color color = HeadColor(run.head, heads);
  canvas.Fill(stretch, color);
  const std::string number = std::to_string(run.head);
  if (canvas.Width(number) + 4 > stretch.width) return;
  canvas.CentredText(left + stretch.width / 2, stretch.bottom + stretch.height / 2, number,
                     TextColorOn(color));
}

/// The steps at which heads change, as many as there is room for; the last one always.
void DrawSteps(const Canvas& canvas, const Scale& scale, const std::vector<HeadRun>& runs, int y) {
  const int gap = canvas.LineHeight();
  const std::string last = std::to_string(scale.steps);
  const int limit = scale.X(scale.steps) - canvas.Width(last) / 2 - gap;
  int free_from = 0;
  for (const HeadRun& run : runs) {
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

std::vector<HeadRun> HeadRuns(const EpisodePath& path) {
  std::vector<HeadRun> runs;
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
  const std::vector<HeadRun> runs = HeadRuns(path);
  const int numbers = scale.bar.bottom + scale.bar.height / 2;
  const int steps = area.bottom + line;
  canvas.Fill(area, kPaper);
  canvas.Text(area.left + line / 2, numbers, "head", kInk);
  canvas.Text(area.left + line / 2, steps, "step", kInk);
  for (const HeadRun& run : runs) DrawRun(canvas, scale, run, path.heads);
  DrawSteps(canvas, scale, runs, steps);
  if (now) DrawMark(canvas, scale, *now);
}

}  // namespace metronome
