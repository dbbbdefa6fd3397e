#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "actor/environment/environment.h"
#include "actor/play/evaluate.h"
#include "common/messages/messages.h"
#include "common/policy/head_schedule.h"
#include "common/schema/config.pb.h"

namespace metronome::render {

/// Where everything in a scene is, as far as drawing needs it.
struct Pose {
  std::vector<double> qpos;
  std::vector<double> mocap_pos;   // [mocap bodies, 3], metres
  std::vector<double> mocap_quat;  // [mocap bodies, 4]
};

/// The scene as it stands.
Pose PoseOf(const mjModel& model, const mjData& data);

/// The state after t steps. Head, reward and success are those of the step that led to it.
struct PathPoint {
  Pose pose;
  std::array<double, 3> hand{};    // metres, as all of Landmarks
  std::array<double, 3> object{};  // metres
  double gripper = 0;              // 0 closed, 1 open
  std::int32_t head = 0;           // among those of the episode's task, [0, k); at t = 0, where no
                                   // step has been: the head of the first one
  double reward = 0;
  bool success = false;
};

/// One episode under the deterministic policy, and where it went.
struct EpisodePath {
  std::int32_t heads = 1;         // k
  std::vector<PathPoint> points;  // [steps + 1]
  play::EvaluatedEpisode outcome;
};

/// The same episode as `evaluate` plays, looked at after every step; looking changes nothing.
/// @param schedule  whose heads act. @param environment  one in MuJoCo.
EpisodePath FollowEpisode(const RunConfig& config, const PolicySnapshot& snapshot,
                          const policy::HeadSchedule& schedule,
                          const environment::EpisodeStart& start,
                          environment::Environment& environment);

/// CSV with the header
/// t,head,hand_x,hand_y,hand_z,gripper,object_x,object_y,object_z,reward,success; row t is the
/// state after t steps, so that the stretch from row t - 1 to row t belongs to row t's head. Row 0
/// is the reset: head, reward and success are empty. Numbers read back as the same doubles.
std::string Csv(const EpisodePath& path);

}  // namespace metronome::render
