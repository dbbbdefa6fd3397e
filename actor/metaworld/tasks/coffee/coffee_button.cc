#include "actor/metaworld/tasks/buttons/button.h"
#include "actor/metaworld/tasks/coffee/coffee.h"
#include "actor/metaworld/tasks/coffee/mug.h"

/// Press the coffee machine's button. As metaworld 3.1.1 has it:
/// envs/sawyer_coffee_button_v3.py.
namespace metronome::metaworld::tasks::coffee {
namespace {

constexpr double kStroke = 0.03;  // of the button, metres
constexpr buttons::ButtonSettings kSettings = {
    .axis = 1, .near_radius = 0.05, .success = 0.02, .reward = buttons::PressOpenHanded};

class CoffeeButton final : public buttons::Pressing {
 public:
  CoffeeButton(const TaskSpec& task, const EnvironmentOptions& options)
      : Pressing(task, options, kSettings),
        machine_(Body("coffee_machine")),
        button_(Site("buttonStart")) {
    to_target_init_ = kStroke;  // whatever the reset left
  }

 private:
  void EditModel(const RandVec& p) override { MoveBody(machine_, ObjectOf(p)); }

  void PlaceObject(const RandVec& p) override {
    object_init_ = ObjectOf(p);
    target_ = object_init_ + Eigen::Vector3d(0, -0.22, 0.3) + Eigen::Vector3d(0, kStroke, 0);
    const Eigen::Vector3d mug = object_init_ + kToMug;
    SetQpos(kMugQpos, {mug.x(), mug.y(), mug.z()});
    Stop(kStoppedQvel, 6);
    Forward();
  }

  [[nodiscard]] ObjectPose Object() const override { return {SitePosition(button_), {1, 0, 0, 0}}; }

  int machine_, button_;
};

}  // namespace

TaskSpec CoffeeButtonTask() {
  return {.name = "coffee-button",
          .family = "coffee",
          .scene = "sawyer_xyz/sawyer_coffee.xml",
          .success = "the button within 2 cm of pressed in",
          .expert = {1.0, 0.0, 498},
          .placement_size = 3,
          .low = {-0.1, 0.8, -0.001},
          .high = {0.1, 0.9, 0.001},
          .goal_box = Box{{-0.1 - 0.001, 0.8 + (-0.22 + kStroke), -0.001 + 0.299},
                          {0.1 + 0.001, 0.9 + (-0.22 + kStroke), 0.001 + 0.301}},
          .hand = {.initial = {0, 0.4, 0.2}},
          .view = {{0.02, 0.68, 0.18}, 1, 140, -20},
          .make = Make<CoffeeButton>};
}

}  // namespace metronome::metaworld::tasks::coffee
