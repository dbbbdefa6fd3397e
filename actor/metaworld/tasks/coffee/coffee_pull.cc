#include "actor/metaworld/tasks/coffee/coffee.h"
#include "actor/metaworld/tasks/coffee/mug.h"

/// Pull a mug out of the coffee machine. As metaworld 3.1.1 has it: envs/sawyer_coffee_pull_v3.py.
namespace metronome::metaworld::tasks::coffee {
namespace {

constexpr MugSettings kSettings = {.in_machine = ObjectOf};

}  // namespace

TaskSpec CoffeePullTask() {
  return {.name = "coffee-pull",
          .family = "coffee",
          .scene = "sawyer_xyz/sawyer_coffee.xml",
          .success = "the mug within 7 cm of the goal",
          .expert = {1.0, 1.0, 4233},
          .low = {-0.05, 0.7, -0.001, -0.1, 0.55, -0.001},
          .high = {0.05, 0.75, 0.001, 0.1, 0.65, 0.001},
          .min_planar_distance = 0.15,
          .hand = {.initial = {0, 0.4, 0.2}},
          .view = {{0.02, 0.68, 0.14}, 0.95, 140, -20},
          .make = Make<Mug, kSettings>};
}

}  // namespace metronome::metaworld::tasks::coffee
