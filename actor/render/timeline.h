#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <optional>
#include <vector>

#include "actor/render/canvas.h"
#include "actor/render/episode_path.h"

namespace metronome::render {

/// Consecutive steps of one head.
struct HeadTurn {
  std::int32_t head = 0;
  std::int32_t begin = 0;  // steps taken when the head takes over
  std::int32_t end = 0;    // steps taken when the next one does
};

/// The heads' turns, in order of time.
std::vector<HeadTurn> HeadTurns(const EpisodePath& path);

/// Pixels that a timeline needs at the foot of an image.
int TimelineHeight(const Canvas& canvas);

/// The legend: the episode as a bar from left to right, each head's stretch in its colour with its
/// number (where there is room), and the steps at which heads change beneath.
/// @param now  steps taken: marks that moment. std::nullopt: no mark.
void DrawTimeline(const Canvas& canvas, const EpisodePath& path, const mjrRect& area,
                  std::optional<std::int32_t> now);

}  // namespace metronome::render
