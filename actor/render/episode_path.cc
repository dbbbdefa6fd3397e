#include "actor/render/episode_path.h"

#include <algorithm>

#include "actor/environment/mujoco_view.h"
#include "common/text/number_text.h"

namespace metronome::render {

Pose PoseOf(const mjModel& model, const mjData& data) {
  return {{data.qpos, data.qpos + model.nq},
          {data.mocap_pos, data.mocap_pos + std::ptrdiff_t{3} * model.nmocap},
          {data.mocap_quat, data.mocap_quat + std::ptrdiff_t{4} * model.nmocap}};
}

EpisodePath FollowEpisode(const RunConfig& config, const PolicySnapshot& snapshot,
                          const policy::HeadSchedule& schedule,
                          const environment::EpisodeStart& start,
                          environment::Environment& environment) {
  const environment::MujocoView& scene = *environment.mujoco();
  EpisodePath path;
  path.heads = config.policy().heads();
  const auto watch = [&](std::int32_t t, const environment::StepOutcome& step) {
    const environment::Landmarks landmarks = scene.landmarks();
    PathPoint point;
    point.pose = PoseOf(scene.model(), scene.data());
    point.hand = landmarks.hand;
    point.object = landmarks.object;
    point.gripper = landmarks.gripper;
    point.head = schedule.HeadAt(std::max(t - 1, 0)) - schedule.first_head();
    point.reward = step.reward;
    point.success = step.success;
    path.points.push_back(std::move(point));
  };
  path.outcome = play::PlayDeterministic(config, snapshot, schedule, start, environment, watch);
  return path;
}

std::string Csv(const EpisodePath& path) {
  std::string text =
      "t,head,hand_x,hand_y,hand_z,gripper,object_x,object_y,object_z,reward,success\n";
  for (std::size_t t = 0; t < path.points.size(); ++t) {
    const PathPoint& point = path.points[t];
    text += std::to_string(t) + ',' + (t > 0 ? std::to_string(point.head) : "");
    for (const double number : point.hand) text += ',' + text::FormatNumber(number);
    text += ',' + text::FormatNumber(point.gripper);
    for (const double number : point.object) text += ',' + text::FormatNumber(number);
    text += t > 0 ? ',' + text::FormatNumber(point.reward) + (point.success ? ",1" : ",0") : ",,";
    text += '\n';
  }
  return text;
}

}  // namespace metronome::render
