#include <algorithm>
#include <cmath>

#include "actor/metaworld/tasks/pushing/pushed_object.h"
#include "actor/metaworld/tasks/pushing/pushing.h"

/// Push a ball into a goal. As metaworld 3.1.1 has it: envs/sawyer_soccer_v3.py.
namespace metronome::metaworld::tasks::pushing {
namespace {

const Eigen::Vector3d kScale(3, 1, 1);

class Soccer final : public PushedObject {
 public:
  Soccer(const TaskSpec& task, const EnvironmentOptions& options)
      : PushedObject(task, options, {.body = "soccer_ball", .height = 0.03, .success = 0.07}),
        frame_(Body("goal_whole")) {}

 private:
  void EditModel(const RandVec& p) override { MoveBody(frame_, GoalOf(p)); }
  [[nodiscard]] Eigen::Vector3d Goal(const RandVec& p, double /*height*/) const override {
    return GoalOf(p);
  }
  [[nodiscard]] ObjectPose Object() const override {
    return {BodyPosition(Pushed()), BodyMatrixQuaternion(Pushed())};
  }

  [[nodiscard]] Reward RewardOf(const Moment& now, float /*gripper*/) const override {
    const double to_target = Norm((now.object - target_).cwiseProduct(kScale));
    const double in_place = InPlace(now.object, to_target);
    const double grasp =
        SignedGrasp(CagingAt(now.object), {.object_radius = 0.013, .xz_threshold = 0.005}, 0.01);
    return {to_target < 0.07 ? 10 : 3 * grasp + 6.5 * in_place, grasp, in_place};
  }

  [[nodiscard]] double InPlace(const Eigen::Vector3d& ball, double to_target) const {
    // The margin is how far the ball has come: 0 at first.
    const double in_place =
        LongTail(to_target, 0, 0.07, Norm((ball - object_init_).cwiseProduct(kScale)));
    const double line = target_.y() - 0.1;
    const bool beside = ball.y() > line && std::abs(ball.x() - target_.x()) > 0.1;
    if (!beside) return in_place;
    return std::clamp(in_place - 2 * (ball.y() - line) / (1 - line), 0.0, 1.0);
  }

  const int frame_;
};

}  // namespace

TaskSpec SoccerTask() {
  return {.name = "soccer",
          .family = "pushing",
          .scene = "sawyer_xyz/sawyer_soccer.xml",
          .success = "the ball within 7 cm of the goal",
          .expert = {1.0, 1.0, 3308},
          .low = {-0.1, 0.6, 0.03, -0.1, 0.8, 0},
          .high = {0.1, 0.7, 0.03, 0.1, 0.9, 0},
          .min_planar_distance = 0.15,
          .hand = {.initial = {0, 0.6, 0.2}},
          .view = {{0.03, 0.74, 0.12}, 0.85, 140, -20},
          .make = Make<Soccer>};
}

}  // namespace metronome::metaworld::tasks::pushing
