#include <cmath>
#include <numbers>

#include "actor/metaworld/sawyer.h"
#include "actor/metaworld/tasks/handles/handles.h"

/// Turn a lever up by its end. As metaworld 3.1.1 has it: envs/sawyer_lever_pull_v3.py.
namespace metronome::metaworld::tasks::handles {
namespace {

constexpr double kQuarterTurn = std::numbers::pi / 2;

class LeverPull final : public SawyerEnvironment {
 public:
  LeverPull(const TaskSpec& task, const EnvironmentOptions& options)
      : SawyerEnvironment(task, options),
        lever_(Body("lever")),
        end_(Site("leverStart")),
        goal_(Site("goal")),
        knob_(Geom("objGeom")),
        axis_(Joint("LeverAxis")) {
    Remember("_lever_pos_init", &end_init_);
  }

 private:
  void EditModel(const RandVec& p) override { MoveBody(lever_, ObjectOf(p)); }

  void PlaceObject(const RandVec& p) override {  // without mj_forward, as official
    object_init_ = ObjectOf(p);
    end_init_ = object_init_ + Eigen::Vector3d(0.12, -0.2, 0.25);
    target_ = object_init_ + Eigen::Vector3d(0.12, 0, 0.45);
    MoveSite(goal_, target_);
  }

  [[nodiscard]] ObjectPose Object() const override {
    return {SitePosition(end_), GeomQuaternion(knob_)};
  }

  Outcome Evaluate(const Observation& observation, const Action& /*action*/) override {
    const Eigen::Vector3d hand = At3(observation.data(), 0);
    const Eigen::Vector3d end = At3(observation.data() + 4, 0);
    const double reached = FromBelow(hand, end);
    const double ready = LongTail(reached, 0, 0.02, FromBelow(tcp_init_, end_init_));
    // The lever turns up to negative angles, whatever its joint's range says.
    const double error = std::abs(-data_->qpos[axis_] - kQuarterTurn);
    const double turned =
        LongTail(error, 0, std::numbers::pi / 48, kQuarterTurn - std::numbers::pi / 12);
    const double in_place = LongTail(Norm(end - target_), 0, 0.04, Norm(end_init_ - target_));
    return {10 * Hamacher(ready, in_place).value(),  // no flat 10 at success
            {.success = error <= std::numbers::pi / 24,
             .near_object = reached < 0.03 ? 1.0 : 0.0,
             .grasp_success = ready > 0.9 ? 1.0 : 0.0,
             .grasp_reward = ready,
             .in_place_reward = turned,  // which the reward does not read
             .obj_to_target = reached}};
  }

  /// Distance of `hand` from the place under the lever's end from which it can lift it.
  static double FromBelow(const Eigen::Vector3d& hand, const Eigen::Vector3d& end) {
    const Eigen::Vector3d offset(0, 0.055, 0.07), scale(4, 1, 4);
    return Norm((hand + offset - end).cwiseProduct(scale));
  }

  const int lever_, end_, goal_, knob_, axis_;
  Eigen::Vector3d end_init_ = Eigen::Vector3d::Zero();
};

}  // namespace

TaskSpec LeverPullTask() {
  return {.name = "lever-pull",
          .family = "handles",
          .scene = "sawyer_xyz/sawyer_lever_pull.xml",
          .success = "the lever within 7.5 degrees of upright",
          .expert = {1.0, 0.0, 727},
          .placement_size = 3,
          .low = {-0.1, 0.7, 0},
          .high = {0.1, 0.8, 0},
          .goal_box = Box{{-0.5, 0.4, -0.15}, {0.5, 1, 0.5}},
          .hand = {.initial = {0, 0.4F, 0.2F}, .low = {-0.5, 0.4, -0.15}, .settles_alike = false},
          .view = {{0.06, 0.64, 0.24}, 0.95, 140, -15},
          .make = Make<LeverPull>};
}

}  // namespace metronome::metaworld::tasks::handles
