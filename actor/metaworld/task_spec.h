#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>

#include "actor/environment/mujoco_view.h"
#include "actor/metaworld/step_result.h"

namespace metronome::metaworld {

class SawyerEnvironment;

/// A task's robot; everything else about it is the same in all scenes.
struct HandSettings {
  /// Where the mocap body waits during the hand initialisation, metres. Where the official task
  /// keeps it in float32, so do the numbers here (0.6F).
  Eigen::Vector3d initial;
  Eigen::Vector3d low{-0.5, 0.4, 0.05};  // box that the mocap body is kept in, metres
  Eigen::Vector3d high{0.5, 1, 0.5};
  /// Whether the state after the hand initialisation is the same for every placement in the task's
  /// box: no body that a placement moves can touch what moves by then.
  bool settles_alike = true;
};

struct Box {
  Eigen::Vector3d low, high;  // metres
};

/// The official scripted policy's episodes of 500 steps: share with success at any step and at the
/// last one, mean return.
struct ExpertLine {
  double success_any, success_last, mean_return;
};

/// Everything about a task that is not its behaviour; tasks/FAMILY/NAME.cc has both. Source:
/// metaworld 3.1.1, envs/sawyer_NAME_v3.py, model_name and __init__.
struct TaskSpec {
  std::string name;        // canonical, e.g. "push"; "push-v2" and "push-v3" name the same task
  std::string family;      // tasks whose scenes and code are alike
  std::string scene;       // XML file, relative to the assets folder
  std::string success;     // what counts as success, for people
  ExpertLine expert;       // measured on 3.3.0, 10 official placements
  int placement_size = 6;  // numbers that a placement has: 6, or 3 without a goal's
  RandVec low, high;       // box that a placement is drawn from, metres
  /// A placement whose object is nearer to `keep_from` in the plane than this is drawn again,
  /// metres; 0: every placement is taken.
  double min_planar_distance = 0;
  std::optional<Eigen::Vector2d> keep_from = std::nullopt;  // unset: the placement's goal
  /// That observed goals are clipped to; unset: the box of the placement's goal.
  std::optional<Box> goal_box = std::nullopt;
  HandSettings hand;
  environment::CameraView view;  // of pictures: shows arm, object and goal
  std::unique_ptr<SawyerEnvironment> (*make)(const TaskSpec&, const EnvironmentOptions&);
};

}  // namespace metronome::metaworld
