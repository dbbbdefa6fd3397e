#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace metronome::metaworld {

inline constexpr int kObservationSize = 39;  // frame 18 | previous frame 18 | goal 3
inline constexpr int kActionSize = 4;        // hand dx, dy, dz, gripper; clipped to -1..1
inline constexpr int kMaxSteps = 500;        // the official time limit

/// Metres, quaternions: the frame of now, the one of a step before (kFrameSize in sawyer.h), the
/// goal's position.
using Observation = std::array<double, kObservationSize>;
using Action = std::array<float, kActionSize>;
/// A placement: xyz of the object (or fixture), then xyz of the goal, metres. Tasks whose placement
/// has three numbers leave the last three 0.
using RandVec = std::array<double, 6>;

/// The official environment's `info` of a step.
struct StepInfo {
  bool success = false;
  double near_object = 0;
  double grasp_success = 0;
  double grasp_reward = 0;
  double in_place_reward = 0;
  double obj_to_target = 0;  // metres
};

struct StepResult {
  Observation observation{};
  double reward = 0;  // 0..10
  StepInfo info;
  bool truncated = false;  // exactly at step 500, the official time limit
};

struct EnvironmentOptions {
  bool goal_visible = true;  // hidden: observation[36..38] are zeros, nothing else changes
  std::string assets;        // folder of the official scene files (".../metaworld/assets")
};

}  // namespace metronome::metaworld
