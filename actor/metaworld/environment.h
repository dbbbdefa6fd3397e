#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/messages/episode.h"

namespace metronome::metaworld {

/// Metres, quaternions: the frame of now, the one of a step before (kFrameSize in sawyer.h), the
/// goal's position.
using Observation = std::array<double, kObservationSize>;
using Action = std::array<float, kActionSize>;
using RandVec = std::array<double, 6>;  // placement: object xyz, goal xyz, metres

/// What the official environment's `info` says of a step.
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

/// One Meta-World scene in MuJoCo. An episode is a pure function of the placement and the actions:
/// no state of an earlier episode survives Reset. Not thread-safe; one per thread.
class Environment {
 public:
  virtual ~Environment() = default;
  /// Starts an episode at `placement`, which rules it wholly (the official package's frozen
  /// rand_vec semantics). @return the first observation, unclipped as the official one is.
  virtual Observation Reset(const RandVec& placement) = 0;
  /// Five physics substeps under `action`. @throws std::logic_error past step 500 or before Reset,
  /// std::invalid_argument if a component is not finite.
  virtual StepResult Step(const Action& action) = 0;
};

}  // namespace metronome::metaworld
