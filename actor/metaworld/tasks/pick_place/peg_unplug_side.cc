#include "actor/metaworld/tasks/pick_place/free_object.h"
#include "actor/metaworld/tasks/pick_place/pick_place.h"

/// Pull a plug sideways out of a box. As metaworld 3.1.1 has it: envs/sawyer_peg_unplug_side_v3.py.
namespace metronome::metaworld::tasks::pick_place {
namespace {

constexpr CagingShape kCaging = {
    .object_radius = 0.025, .pad_success = 0.05, .xz_threshold = 0.005, .effort = 0.8};

class PegUnplugSide final : public FreeObject {
 public:
  PegUnplugSide(const TaskSpec& task, const EnvironmentOptions& options)
      : FreeObject(task, options, "plug1", "goal"), box_(Body("box")), end_(Site("pegEnd")) {}

 private:
  void EditModel(const RandVec& p) override { MoveBody(box_, ObjectOf(p)); }

  void PlaceObject(const RandVec& p) override {
    const Eigen::Vector3d plug = ObjectOf(p) + Eigen::Vector3d(0.044, 0, 0.131);
    SetTarget(plug + Eigen::Vector3d(0.15, 0, 0));
    SetQpos(kPlugQpos, {plug.x(), plug.y(), plug.z(), 1, 0, 0, 0});
    Stop(kPlugQvel, 3);  // it turns on: as official
    Forward();
    object_init_ = SitePosition(end_);
  }

  [[nodiscard]] ObjectPose Object() const override {
    return {SitePosition(end_), BodyQuaternion(object_)};
  }

  Outcome Evaluate(const Observation& observation, const Action& action) override {
    const Situation now = See(observation);
    const double in_place = InPlace(now);
    const Scalar grasp = Caging(now.object, kCaging, action[3]);
    const bool pulled = now.opening > 0.5 && now.object.x() - object_init_.x() > 0.015;

    Scalar reward = 2 * grasp;
    if (pulled && now.to_object < 0.035) reward = 1 + 2 * grasp + 5 * in_place;
    if (now.to_target <= 0.05) reward = 10;
    return Conclude(now,
                    {.reward = reward, .grasp = grasp, .in_place = in_place, .grasped = pulled});
  }

  static constexpr int kPlugQpos = 9, kPlugQvel = 9;

  int box_, end_;
};

}  // namespace

TaskSpec PegUnplugSideTask() {
  return {
      .name = "peg-unplug-side",
      .family = "pick_place",
      .scene = "sawyer_xyz/sawyer_peg_unplug_side.xml",
      .success = "the plug's end within 7 cm of the goal, 15 cm out of the box",
      .expert = {0.9, 0.0, 1177},
      .placement_size = 3,
      .low = {-0.25, 0.6, -0.001},
      .high = {-0.15, 0.8, 0.001},
      .goal_box = Box{{-0.25 + 0.194, 0.6, -0.001 + 0.131}, {-0.15 + 0.194, 0.8, 0.001 + 0.131}},
      .hand = {.initial = {0, 0.6, 0.2}, .settles_alike = false},  // the box takes the plug
      .view = {{-0.08, 0.68, 0.13}, 0.85, 125, -20},
      .make = Make<PegUnplugSide>};
}

}  // namespace metronome::metaworld::tasks::pick_place
