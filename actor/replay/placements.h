#pragma once

#include <cstdint>
#include <ostream>
#include <string>

namespace metronome::replay {

struct PlacementsOptions {
  std::string task;       // any accepted spelling
  std::string mode;       // "random" | "fixed" | "mt1"
  std::string benchmark;  // in place of task, mode and count, "mt10" ...
  std::uint64_t seed = 1;
  std::uint64_t count = 0;  // 0: 50 for mt1 (all there are), 1 for fixed, 10 for random
};

/// `metronome-actor placements`: one CSV row a placement, after the header
/// obj_x,obj_y,obj_z,goal_x,goal_y,goal_z (without the goal where the task's placements have three
/// numbers); metres, numbers that read back as the same doubles.
/// random: those of training episodes 0, 1, ... of that seed. fixed: the one of that seed, `count`
/// times. mt1: the official benchmark's first `count`.
/// With a benchmark all of its placements, 50 a task: columns task and index come first (before
/// them split, train or test, where it has both), and what a task's placements lack is left empty.
/// @return exit status: 0; 2 for bad options, with the reason on stderr and nothing on `out`.
int RunPlacements(const PlacementsOptions& options, std::ostream& out);

}  // namespace metronome::replay
