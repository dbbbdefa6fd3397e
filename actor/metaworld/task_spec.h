#pragma once

#include <memory>
#include <string>

#include "actor/environment/mujoco_view.h"
#include "actor/metaworld/step_result.h"

namespace metronome::metaworld {

class SawyerEnvironment;

/// Everything about a task that is not its behaviour. One row of the table a task; behaviour is in
/// tasks/NAME.cc. Source: metaworld 3.1.1, envs/sawyer_NAME_v3.py, model_name and __init__.
struct TaskSpec {
  std::string name;   // canonical, e.g. "push"; "push-v2" and "push-v3" name the same task
  std::string scene;  // XML file, relative to the assets folder
  RandVec low, high;  // box that a placement is drawn from, metres
  /// A placement whose planar distance between object and goal is below this is drawn again,
  /// metres; 0: every placement is taken.
  double min_planar_distance;
  environment::CameraView view;  // of pictures: shows arm, object and goal
  std::unique_ptr<SawyerEnvironment> (*make)(const TaskSpec&, const EnvironmentOptions&);
};

}  // namespace metronome::metaworld
