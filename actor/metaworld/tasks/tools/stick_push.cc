#include "actor/metaworld/tasks/tools/stick.h"
#include "actor/metaworld/tasks/tools/tools.h"

/// Push a container with a stick. As metaworld 3.1.1 has it: envs/sawyer_stick_push_v3.py.
namespace metronome::metaworld::tasks::tools {
namespace {

constexpr CagingShape kCaging = {.object_radius = 0.04, .pad_success = 0.05, .xz_threshold = 0.01};

class StickPush final : public Stick {
 public:
  StickPush(const TaskSpec& task, const EnvironmentOptions& options)
      : Stick(task, options, 0, 0.09) {}

 private:
  [[nodiscard]] double GoalHeight() const override { return HandlePosition().z(); }

  Outcome Evaluate(const Observation& observation, const Action& action) override {
    const Eigen::Vector3d stick =
        At3(observation.data() + 4, 0) + Eigen::Vector3d(0.015, 0, 0);  // where to take it
    const double tcp_to_stick = Norm(stick - Tcp());
    const double to_target = Norm(At3(observation.data() + 11, 0) - target_);
    const double stick_in_place = InPlace(Norm(stick - target_), StickInit());
    const bool held =
        tcp_to_stick < 0.02 && observation[3] > 0 && stick.z() - 0.01 > StickInit().z();

    CagingState state = CagingAt(stick);
    state.object_init = StickInit();
    const Scalar grasp = held ? 1 : metaworld::Caging(state, kCaging, action[3]);
    Scalar reward = grasp;
    if (held) reward = 2 + 5 * stick_in_place + 3 * InPlace(to_target, object_init_);
    if (held && to_target <= 0.12) reward = 10;
    const bool grasped = Grasped(observation, 0.01, StickInit().z());
    return {reward.value(),
            {.success = grasped && to_target <= 0.12,
             .near_object = tcp_to_stick <= 0.03 ? 1.0 : 0.0,
             .grasp_success = grasped ? 1.0 : 0.0,
             .grasp_reward = grasp.value(),
             .in_place_reward = stick_in_place,
             .obj_to_target = to_target}};
  }

  [[nodiscard]] double InPlace(double to_target, const Eigen::Vector3d& first) const {
    return LongTail(to_target, 0, 0.12, Norm(first - target_) - 0.12);
  }
};

}  // namespace

TaskSpec StickPushTask() {
  return {
      .name = "stick-push",
      .family = "tools",
      .scene = "sawyer_xyz/sawyer_stick_obj.xml",
      .success = "the container within 12 cm of the goal, the stick between the pads and lifted",
      .expert = {1.0, 0.0, 1233},
      .low = {-0.08, 0.58, 0, 0.399, 0.55, 0.1319},
      .high = {-0.03, 0.62, 0.001, 0.401, 0.6, 0.1321},
      .min_planar_distance = 0.1,
      .hand = {.initial = {0, 0.6, 0.2}},
      .view = {{0.14, 0.58, 0.14}, 1, 120, -20},
      .make = Make<StickPush>};
}

}  // namespace metronome::metaworld::tasks::tools
