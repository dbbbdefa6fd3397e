#include "actor/metaworld/tasks/knobs/faucet.h"
#include "actor/metaworld/tasks/knobs/knobs.h"

/// Turn a faucet anticlockwise, seen from above. As metaworld 3.1.1 has it:
/// envs/sawyer_faucet_open_v3.py.
namespace metronome::metaworld::tasks::knobs {
namespace {

constexpr FaucetSettings kSettings = {.handle = "handleStartOpen",
                                      .goal = "goal_open",
                                      .goal_x = 0.175,
                                      .grip = {-0.04, 0, 0.03},
                                      .forward = false};

}  // namespace

TaskSpec FaucetOpenTask() {
  return {.name = "faucet-open",
          .family = "knobs",
          .scene = "sawyer_xyz/sawyer_faucet.xml",
          .success = "the handle's end within 7 cm of the goal",
          .expert = {1.0, 0.6, 4182},
          .placement_size = 3,
          .low = {-0.05, 0.8, 0},
          .high = {0.05, 0.85, 0},
          .goal_box = HandBox(-0.15),
          .hand = {.initial = {0, 0.4, 0.2}, .low = {-0.5, 0.4, -0.15}},
          .view = {{0.02, 0.68, 0.14}, 0.9, 140, -25},
          .make = Make<Faucet, kSettings>};
}

}  // namespace metronome::metaworld::tasks::knobs
