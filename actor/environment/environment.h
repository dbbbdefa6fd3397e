#pragma once

#include <span>

#include "actor/environment/episode_start.h"

namespace metronome::environment {

class MujocoView;

/// The outcome of a step. The observation after it goes to the caller's memory.
struct StepOutcome {
  double reward = 0;
  bool success = false;     // the success criterion holds after the step; false without one
  bool terminated = false;  // the state after the step is absorbing: nothing follows
  bool truncated = false;   // the environment cuts the episode here, though it could go on
};

/// An environment to learn in, as its EnvironmentSpec (common/schema/config.proto) describes it; O
/// and A are its sizes of observation and action. An episode is a pure function of its start, the
/// actions and the configuration that the environment was made with: no state of an earlier episode
/// survives Reset, and every random number comes from the start's stream (an environment that needs
/// some in its steps keeps a copy). Not thread-safe; one per thread.
class Environment {
 public:
  virtual ~Environment() = default;
  /// @param observation  [O], written: the first one.
  virtual void Reset(EpisodeStart& start, std::span<float> observation) = 0;
  /// @param action  [A], clipped here to the specification's bounds. @param observation  [O],
  /// written. @throws std::logic_error after the episode's end or before Reset,
  /// std::invalid_argument for an action that is not finite.
  virtual StepOutcome Step(std::span<const float> action, std::span<float> observation) = 0;
  /// The scene for pictures; nullptr: it cannot be drawn.
  [[nodiscard]] virtual const MujocoView* mujoco() const { return nullptr; }
};

}  // namespace metronome::environment
