#pragma once

#include "actor/metaworld/sawyer.h"

/// What tasks with a faucet share.
namespace metronome::metaworld::tasks::knobs {

struct FaucetSettings {
  const char* handle;          // site that is observed
  const char* goal;            // site that marks the goal
  double goal_x;               // of the goal, seen from the faucet, metres
  std::array<double, 3> grip;  // where the handle is pushed, seen from the observed place
  bool forward;                // whether the official reset ends with mj_forward
};

class Faucet final : public SawyerEnvironment {
 public:
  Faucet(const TaskSpec& task, const EnvironmentOptions& options, const FaucetSettings& settings);

 private:
  void EditModel(const RandVec& p) override { MoveBody(base_, ObjectOf(p)); }
  void PlaceObject(const RandVec& p) override;
  [[nodiscard]] ObjectPose Object() const override;
  Outcome Evaluate(const Observation& observation, const Action& action) override;

  const FaucetSettings& settings_;
  int base_, handle_, goal_;
};

}  // namespace metronome::metaworld::tasks::knobs
